"""Jobs side by side: functions of their arguments alone, done in this process, in others of this machine or on a cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from time import monotonic, process_time
from typing import Any, TypeVar, cast

from joblib import Parallel, delayed
from joblib.parallel import get_active_backend
from tqdm import tqdm

from hexwar_sb3.evaluation.cluster import is_elsewhere
from hexwar_sb3.evaluation.parcels import Parcel, Result, leave, nothing, pack, work
from hexwar_sb3.folders import Held, held, work_within
from hexwar_sb3.processes import end_with, keep_memory

Spec = TypeVar("Spec")
Made = TypeVar("Made")
_elsewhere: list[float] = []  # core seconds of calls that other processes have ended for this one


def core_seconds() -> float:
    """Processor time so far of this process and of the calls of `run_jobs` that others have ended for it."""
    return process_time() + sum(_elsewhere)


def run_jobs(
    function: Callable[[Spec], Made],
    specs: Sequence[Spec],
    jobs: int,
    what: str,
    leaves: Callable[[Spec], Iterable[Path]] = nothing,
) -> list[Made]:
    """Call a function once a spec, some calls side by side by joblib, and show how many have begun.

    They are done in this process or in others of this machine (loky), or where a backend says that `joblib.parallel_config`
    names, such as `working_on` a cluster. There files travel (`parcels`), and are written here as each job ends.

    Args:
        function: leaves what is large in files.
        specs: its arguments; with more than one job they are pickled.
        jobs: calls side by side; on this machine 1 stays in this process.
        what: one of them, in a word.
        leaves: files and folders that a call makes for a spec.

    Returns:
        What the calls return, in the order of the specs.

    Raises:
        ClusterError: a worker elsewhere is another program, or failed; its own errors of ours are raised as they are.
    """
    shown = tqdm(specs, unit=what, dynamic_ncols=True, leave=False, disable=None)
    if is_elsewhere():
        return _run_elsewhere(function, shown, jobs, leaves)
    workers, start = min(jobs, max(1, len(specs))), monotonic()  # loky would start all of them
    with warnings.catch_warnings():
        # Maps that a game reads into memory look like a leak, and loky starts another worker: nothing is lost.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        try:
            calls = Parallel(n_jobs=workers)(
                delayed(_call)(function, spec, os.getpid(), held()) for spec in shown
            )
        except BaseException:  # what had ended counts too: as if all were busy until now
            _elsewhere.append((monotonic() - start) * workers if workers > 1 else 0.0)
            raise
    _elsewhere.extend(seconds for _, seconds in calls)
    return cast("list[Made]", [made for made, _ in calls])


def _run_elsewhere(
    function: Callable[[Spec], Made],
    shown: Iterable[Spec],
    jobs: int,
    leaves: Callable[[Spec], Iterable[Path]],
) -> list[Made]:
    """Let workers on other machines make the calls, and write what they leave as soon as it is there."""
    places: dict[int, list[Path]] = {}
    trouble: list[Exception] = []  # joblib asks for parcels in threads, where errors would be lost

    def parcels() -> Iterator[Any]:
        try:
            for number, spec in enumerate(shown):
                places[number] = list(leaves(spec))
                yield delayed(_numbered)(number, pack(function, spec, leaves))
        except Exception as error:  # noqa: BLE001  raised below
            trouble.append(error)

    made: dict[int, Any] = {}
    with _ended(parcels(), jobs) as ended:
        for number, result in ended:
            if result.error is not None:
                raise result.error
            for files, place in zip(result.files, places[number], strict=True):
                if files is not None:
                    leave(files, place)
            _elsewhere.append(result.seconds)
            made[number] = result.made
    if trouble:
        raise trouble[0]
    return [made[number] for number in sorted(made)]


@contextmanager
def _ended(parcels: Iterator[Any], jobs: int) -> Iterator[Iterable[tuple[int, Result]]]:
    """Results of parcels as they come, where the backend gives them so; after the block no job runs any more."""
    can_stream = get_active_backend()[0].supports_return_generator
    kind = "generator_unordered" if can_stream else "list"
    results = Parallel(jobs, return_as=kind, pre_dispatch="n_jobs")(parcels)
    try:
        yield results
    finally:
        if can_stream:
            with warnings.catch_warnings(
                action="ignore", category=UserWarning
            ):  # that not all were waited for
                results.close()


def _numbered(number: int, parcel: Parcel) -> tuple[int, Result]:
    return number, work(parcel)


def _call(function: Callable[[Spec], Made], spec: Spec, waiting: int, folders: Held) -> tuple[Made, float]:
    """Call it: what it returns, and core seconds if this is another process than the one that waits.

    In a process of its own Ctrl-C ends it without a word: the process that waits says what is to be said.

    A process of this machine's ends with the one that waits, and makes no folder anew that this one holds.
    """
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid == waiting:
        end_with(waiting)
        keep_memory()
        work_within(folders)
    if os.getpid() != waiting and current_thread() is main_thread():
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    start = process_time()
    return function(spec), process_time() - start if os.getpid() != waiting else 0.0
