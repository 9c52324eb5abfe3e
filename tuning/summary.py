"""A study in figures: its trials, what pruning saved, the best point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import optuna
from optuna.trial import FrozenTrial, TrialState

from hexwar_sb3.algorithms.preset_file import load_preset
from hexwar_sb3.tuning.space import first_point, short
from hexwar_sb3.tuning.study import REASON, StudySpec

LayOut = Callable[[Sequence[str], Sequence[Sequence[str]]], str]  # heads and rows, as text


def summary(study: optuna.Study, spec: StudySpec) -> dict[str, Any]:
    """All figures as JSON values; the best point only where a trial was completed."""
    trials = study.get_trials(deepcopy=False)
    count = {state.name.lower(): sum(one.state == state for one in trials) for state in TrialState}
    judged = [one for one in trials if one.state in (TrialState.COMPLETE, TrialState.PRUNED)]
    done = sorted(
        (one for one in judged if one.state == TrialState.COMPLETE),
        key=lambda one: (-(one.value or 0.0), one.number),
    )
    paper = first_point(load_preset(spec.preset), spec.space)
    papers = sorted((one for one in trials if one.params == paper), key=lambda one: one not in done)
    return {
        "study": spec.folder.name,
        "trials": [_row(one) for one in trials],
        "count": count,
        "ticks": sum(int(one.user_attrs["ticks"]) for one in judged),
        "ticks_without_pruning": spec.common.ticks * len(judged),
        "minutes": sum(_minutes(one) for one in trials if one in judged or REASON in one.user_attrs),
        "best": _row(done[0]) if done else None,
        "paper": _row(papers[0]) if papers else None,
    }


def in_words(figures: Mapping[str, Any], lay_out: LayOut) -> str:
    """The trials from the best to the worst, and what the study cost."""
    order = sorted(
        figures["trials"], key=lambda row: (row["value"] is None, -(row["value"] or 0.0), row["number"])
    )
    names = list(dict.fromkeys(name for row in order for name in row["point"]))
    rows = [
        [
            str(row["number"]),
            row["state"],
            *(short(row["point"].get(name, "")) for name in names),
            *("" if row[name] is None else short(row[name]) for name in ("value", "win_rate")),
            " ".join(f"{one:+.2f}" for one in row["trainings"]),
            row["reason"] or "",
        ]
        for row in order
    ]
    count = ", ".join(f"{number} {state}" for state, number in figures["count"].items() if number)
    ticks, whole = figures["ticks"], figures["ticks_without_pruning"]
    saved = max(0.0, 1 - ticks / whole) if whole else 0.0  # a trial may take a few ticks more
    cost = f"{ticks / 1e6:.1f} million ticks, {100 * saved:.0f} % saved by pruning"
    return "\n\n".join(
        [
            lay_out(("trial", "state", *names, "margin / force", "win rate", "trainings", ""), rows),
            f"{count}; {cost}; {figures['minutes']:.1f} core-minutes",
            "\n".join(figures["pictures"]),
        ]
    )


def _row(trial: FrozenTrial) -> dict[str, Any]:
    own = trial.user_attrs
    return {
        "number": trial.number,
        "state": trial.state.name.lower(),
        "point": dict(trial.params),
        "value": trial.value if trial.state == TrialState.COMPLETE else None,
        "trainings": list(own.get("trainings", ())),
        "win_rate": own.get("win_rate"),
        "points_held": own.get("points_held"),
        "agreement": own.get("agreement"),
        "ticks": own.get("ticks"),
        "minutes": _minutes(trial),
        "reason": own.get(REASON),
    }


def _minutes(trial: FrozenTrial) -> float:
    return trial.duration.total_seconds() / 60 if trial.duration is not None else 0.0
