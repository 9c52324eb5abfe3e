"""That alpha and beta matter to the objective, and that pruning saves what it prunes: minutes of training."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from optuna.trial import TrialState

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.tuning.objective import Common, train_once
from hexwar_sb3.tuning.space import PAPER, Point
from hexwar_sb3.tuning.study import StudySpec, begin, run_study
from hexwar_sb3.tuning.summary import summary
from tests.tuning.conftest import SMALL


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_a_team_reward_that_outweighs_the_cost_of_a_step_is_worth_clearly_less(tmp_path: Path) -> None:
    """A third of a force less than the paper's point, and than the same alpha with a beta that keeps up with it."""

    def reached(point: Point) -> float:
        return train_once(PRESETS["default"].changed(point), Common(), 0, tmp_path / "policy").margin

    outweighs = reached({**PAPER, "alpha": 1.0})
    assert outweighs < reached(PAPER) - 1 / 3
    assert outweighs < reached({**PAPER, "alpha": 1.0, "beta": 0.5}) - 1 / 3


@pytest.mark.slow
def test_pruning_saves_ticks_at_equal_trials(spec: StudySpec) -> None:
    whole = replace(spec, common=replace(SMALL, trainings=3))
    pruned = replace(whole, folder=spec.folder.parent / "pruned", pruner="halving")
    ticks = {}
    for one in (whole, pruned):
        run_study(one, 8, say=lambda _: None)
        study = begin(one)
        ticks[one.pruner] = summary(study, one)["ticks"]
    with_all, without_some = begin(whole).trials, begin(pruned).trials

    assert [one.params for one in with_all] == [one.params for one in without_some]
    assert TrialState.PRUNED in {one.state for one in without_some}
    assert ticks["halving"] < ticks["none"]
    for trial, other in zip(with_all, without_some, strict=True):  # the same trainings, as many as there are
        assert other.intermediate_values.items() <= trial.intermediate_values.items()
