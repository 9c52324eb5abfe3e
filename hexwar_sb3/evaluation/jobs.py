"""Jobs side by side: functions of their arguments alone."""

from __future__ import annotations

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Sequence
from threading import current_thread, main_thread
from time import monotonic, process_time
from typing import TypeVar, cast

from joblib import Parallel, delayed
from tqdm import tqdm

from hexwar_sb3.folders import Held, held, work_within
from hexwar_sb3.processes import end_with, keep_memory

Spec = TypeVar("Spec")
Made = TypeVar("Made")
_elsewhere: list[float] = []  # core seconds of calls that other processes have ended for this one


def core_seconds() -> float:
    """Processor time so far of this process and of the calls of `run_jobs` that others have ended for it."""
    return process_time() + sum(_elsewhere)


def run_jobs(function: Callable[[Spec], Made], specs: Sequence[Spec], jobs: int, what: str) -> list[Made]:
    """Call a function once a spec, some calls side by side in processes of joblib, and show how many have begun.

    The backend is joblib's own (loky) or the one that `joblib.parallel_config` names.

    Args:
        function: leaves what is large in files.
        specs: its arguments; with more than one job they are pickled.
        jobs: calls side by side; 1 stays in this process.
        what: one of them, in a word.

    Returns:
        What the calls return, in the order of the specs.
    """
    shown = tqdm(specs, unit=what, dynamic_ncols=True, leave=False, disable=None)
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
