"""Who works on a trial, and what becomes of trials whose process is gone."""

from __future__ import annotations

import os
import socket
import warnings
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import optuna
from filelock import FileLock, Timeout
from optuna.exceptions import ExperimentalWarning, UpdateFinishedTrialError
from optuna.storages import fail_stale_trials
from optuna.trial import FrozenTrial, TrialState

WORKER, AGAIN = "worker", "again"  # attributes of a trial: its process; which trial it repeats
PATIENCE_S = 120.0  # a trial that has not said by then who works on it has nobody
ENDED = (TrialState.COMPLETE, TrialState.PRUNED, TrialState.FAIL)


def this_process() -> dict[str, Any]:
    """Name this process."""
    return {"host": socket.gethostname(), "pid": os.getpid()}


def is_gone(trial: FrozenTrial, lock: Path) -> bool:
    """Whether nobody works on a running trial any more.

    Args:
        trial: says who works on it once it holds the lock.
        lock: file that its process holds until it ends, however it ends. Machines without a common folder do not see
            each other's locks: of them only a database's heartbeats tell.
    """
    worker = trial.user_attrs.get(WORKER)
    if worker is None:
        begun = trial.datetime_start
        return begun is None or (datetime.now(begun.tzinfo) - begun).total_seconds() > PATIENCE_S
    if not lock.exists():
        return bool(worker["host"] == socket.gethostname())
    try:
        with FileLock(lock, timeout=0):
            return True
    except Timeout:
        return False


def bury(study: optuna.Study, lock_of: Callable[[int], Path]) -> None:
    """Fail the trials whose process is gone, and put their points in line once more."""
    with warnings.catch_warnings(action="ignore", category=ExperimentalWarning):
        fail_stale_trials(study)  # of other machines, by heartbeats
    for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
        if is_gone(trial, lock_of(trial.number)):
            try:
                study.tell(trial.number, state=TrialState.FAIL)
            except (ValueError, UpdateFinishedTrialError):  # another process was faster
                continue
            comes_again(study, trial)


def comes_again(study: optuna.Study, trial: FrozenTrial) -> None:
    """Put the point of a failed trial in line, unless it was there for the second time."""
    if AGAIN not in trial.user_attrs:
        point = {**trial.system_attrs.get("fixed_params", {}), **trial.params}
        study.enqueue_trial(point, user_attrs={AGAIN: trial.number})


def ended(trials: list[FrozenTrial]) -> int:
    """How many trials have ended, those apart that come or came again."""
    return sum(one.state in ENDED for one in trials) - sum(AGAIN in one.user_attrs for one in trials)
