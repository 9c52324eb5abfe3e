"""Jobs side by side: functions of their arguments alone."""

from __future__ import annotations

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Sequence
from threading import current_thread, main_thread
from typing import TypeVar, cast

from joblib import Parallel, delayed
from tqdm import tqdm

from hexwar_sb3.folders import Held, held, work_within
from hexwar_sb3.processes import end_with, keep_memory

Spec = TypeVar("Spec")
Made = TypeVar("Made")


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
    with warnings.catch_warnings():
        # Maps that a game reads into memory look like a leak, and loky starts another worker: nothing is lost.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        parallel = Parallel(n_jobs=min(jobs, max(1, len(specs))))  # loky would start all of them
        made = parallel(delayed(_call)(function, spec, os.getpid(), held()) for spec in shown)
    return cast("list[Made]", made)


def _call(function: Callable[[Spec], Made], spec: Spec, waiting: int, folders: Held) -> Made:
    """Call it; in a process of its own Ctrl-C ends it without a word: the process that waits says what is to be said.

    A process of this machine's ends with the one that waits, and makes no folder anew that this one holds.
    """
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid == waiting:
        end_with(waiting)
        keep_memory()
        work_within(folders)
    if os.getpid() != waiting and current_thread() is main_thread():
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return function(spec)
