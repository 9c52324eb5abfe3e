"""What a study's trials say of themselves, checked before it is used: a storage may be a stranger's."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from optuna.trial import FrozenTrial, TrialState

from hexwar_sb3.errors import FileFormatError, HexWarError
from hexwar_sb3.kinds import fits, read_fields
from hexwar_sb3.tuning.space import Space, checked_point

JUDGED = (TrialState.COMPLETE, TrialState.PRUNED)
RUNG = "completed_rung_"  # Optuna's names of what its halving compares, but for the number


@dataclass(frozen=True, kw_only=True)
class Process:
    """Whose process works on a trial."""

    host: str
    pid: int


@dataclass(frozen=True, kw_only=True)
class Attributes:
    """Attributes of a trial that are read; all may be missing but the ticks of one that was judged."""

    ticks: int = 0
    win_rate: float = 0.0
    points_held: float = 0.0
    agreement: float = 0.0
    trainings: tuple[float, ...] = ()
    reason: str = ""
    again: int = 0


def check_trials(trials: Iterable[FrozenTrial], space: Space, study: str) -> None:
    """Check values, points, reports and attributes of trials.

    Args:
        trials: of the study.
        space: that it searches.
        study: its name, in messages.

    Raises:
        FileFormatError: one says what no trial of ours does.
    """
    for trial in trials:
        place = f"trial {trial.number}"
        attributes: tuple[object, ...] = (trial.user_attrs, trial.system_attrs)
        if not all(isinstance(one, dict) for one in attributes):
            raise FileFormatError(study, f"{place}.attributes", found="others", expected="values by name")
        _check_values(trial, study, place)
        own = trial.user_attrs
        read = {name: own[name] for name in Attributes.__dataclass_fields__ if name in own}
        read_fields(Attributes, read, study, place=place)
        if "worker" in own:
            read_fields(Process, own["worker"], study, place=f"{place}.worker", whole=True)
        if trial.state in JUDGED:
            _check_judged(trial, space, study, place)
        for which, point in (("params", trial.params), ("point", trial.system_attrs.get("fixed_params", {}))):
            try:
                checked_point(point, space)
            except HexWarError as error:
                expected = "values of the searched space"
                raise FileFormatError(
                    study, f"{place}.{which}", found=str(error), expected=expected
                ) from error


def _check_values(trial: FrozenTrial, study: str, place: str) -> None:
    values = [] if trial.values is None else list(trial.values)
    reports = [*trial.intermediate_values.items()]
    if trial.state == TrialState.COMPLETE and (len(values) != 1 or not math.isfinite(values[0])):
        raise FileFormatError(study, f"{place}.values", found=repr(values), expected="one finite number")
    if not all(fits(step, int) and fits(value, float) for step, value in reports):
        raise FileFormatError(
            study, f"{place}.reports", found=repr(reports), expected="finite numbers by step"
        )
    for name, value in trial.system_attrs.items():
        if name.startswith(RUNG) and not fits(value, float):
            raise FileFormatError(study, f"{place}.{name}", found=repr(value), expected="a finite number")


def _check_judged(trial: FrozenTrial, space: Space, study: str, place: str) -> None:
    missing = [*(name for name in space if name not in trial.params)]
    missing += ["ticks"] if "ticks" not in trial.user_attrs else []
    if missing:
        raise FileFormatError(study, place, found=f"no {missing[0]}", expected="its point, and its ticks")
