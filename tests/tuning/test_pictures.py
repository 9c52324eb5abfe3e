"""Pictures and figures of studies of every shape; no trial is trained."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import optuna
import pytest
from optuna.trial import FrozenTrial, TrialState

from hexwar_sb3.tuning.objective import Common
from hexwar_sb3.tuning.pictures import _draw_race, draw_study
from hexwar_sb3.tuning.space import PAPER, Point, space_of
from hexwar_sb3.tuning.study import REASON, StudySpec
from hexwar_sb3.tuning.summary import summary
from hexwar_sb3.tuning.workers import AGAIN

COMMON = Common(trainings=2, lower_ticks=50, upper_ticks=150)
MINUTES = 3.0


def trial(point: Point, state: TrialState, value: float | None = None, **attributes: Any) -> FrozenTrial:
    """One that took three minutes."""
    begun = datetime(2026, 1, 1, tzinfo=UTC)
    values = {} if state == TrialState.FAIL else {1: -0.5, **({} if value is None else {2: value})}
    made = optuna.trial.create_trial(
        params=point,
        distributions={name: one for name, one in space_of(point).items() if name in point},
        state=state,
        value=value,
        intermediate_values=values,
        user_attrs=attributes,
    )
    made.datetime_start = begun
    made.datetime_complete = begun + timedelta(minutes=MINUTES)
    return made


def study_of(trials: Sequence[FrozenTrial]) -> optuna.Study:
    study = optuna.create_study(direction="maximize")
    study.add_trials(trials)
    return study


COMPLETE, PRUNED, FAIL = TrialState.COMPLETE, TrialState.PRUNED, TrialState.FAIL
DONE = {"value": 0.5, "ticks": 400}
STUDIES = {
    "one trial": [trial(PAPER, COMPLETE, **DONE)],
    "one line of points": [
        trial({**PAPER, "alpha": alpha}, COMPLETE, value=alpha, ticks=400) for alpha in (0.01, 0.1, 1.0)
    ],
    "the same point often": [trial(PAPER, COMPLETE, **DONE)] * 5,
    "a surface, and pruned ones": [
        *(
            trial({**PAPER, "alpha": alpha, "beta": beta}, COMPLETE, value=alpha - beta, ticks=400)
            for alpha in (0.01, 0.1)
            for beta in (0.01, 0.1)
        ),
        trial({**PAPER, "decision_ticks": 300}, PRUNED, ticks=200),
    ],
    "names, and no value": [
        trial({**PAPER, "mixer": mixer, "td_lambda": decay}, COMPLETE, **DONE)
        for mixer in ("vdn", "iql")
        for decay in (None, 0.8)
    ],
}


@pytest.mark.parametrize("what", STUDIES)
def test_every_study_has_its_pictures(what: str, tmp_path: Path) -> None:
    trials = STUDIES[what]
    drawn = draw_study(study_of(trials), tmp_path)

    enough = sum(one.state == COMPLETE for one in trials) >= 4
    names = ["surface", "race", "history", "slices", *(["importances"] if enough else [])]
    assert [path.stem for path in drawn] == names
    assert all(path.stat().st_size > 5_000 for path in drawn)


def test_the_race_is_the_mean_by_number_of_trainings_and_who_is_pruned_ends_in_x() -> None:
    lines = _draw_race(STUDIES["a surface, and pruned ones"]).get_lines()

    assert [list(line.get_xdata()) for line in lines] == [[1, 2]] * 4 + [[1]]
    assert [line.get_ydata()[-1] for line in lines] == pytest.approx([0.0, -0.09, 0.09, 0.0, -0.5])
    assert [line.get_marker() for line in lines] == ["o"] * 4 + ["x"]
    assert {tuple(line.get_markevery()) for line in lines} == {(-1,)}


def test_a_study_without_a_completed_trial_has_none(tmp_path: Path) -> None:
    assert draw_study(study_of([trial(PAPER, FAIL)]), tmp_path) == []


def test_a_summary_counts_who_was_judged(tmp_path: Path) -> None:
    """One complete, one pruned after the first of two trainings, one that failed by itself, one that died and came again."""
    other = {**PAPER, "alpha": 0.5}
    study = study_of(
        [
            trial(PAPER, FAIL, ticks=50),
            trial(other, PRUNED, ticks=200),
            trial(other, FAIL, None, **{"ticks": 400, REASON: "TrainingError"}),
            trial(PAPER, COMPLETE, 0.5, **{"ticks": 400, AGAIN: 0}),
        ]
    )
    found = summary(study, StudySpec(folder=tmp_path, common=COMMON))

    assert (found["ticks"], found["ticks_without_pruning"]) == (600, 800)
    assert found["minutes"] == 3 * MINUTES
    assert found["best"]["number"] == found["paper"]["number"] == 3
