"""That alpha and beta matter to the objective, and that pruning saves what it prunes: minutes of training."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from optuna.trial import FixedTrial, TrialState

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.tuning.objective import Common, objective
from hexwar_sb3.tuning.space import PAPER, Point
from hexwar_sb3.tuning.study import StudySpec, begin, run_study
from hexwar_sb3.tuning.summary import summary
from tests.tuning.conftest import SMALL


@pytest.mark.slow
@pytest.mark.parametrize("extreme", [{"alpha": 1.0}, {"beta": 0.5, "alpha": 1.0}])
def test_extreme_alpha_and_beta_are_worth_clearly_less(extreme: Point, tmp_path: Path) -> None:
    """A third of a force less, with a third of the usual budget."""
    common = Common(lower_ticks=1_000_000, upper_ticks=2_700_000, reports=1, report_games=1, final_games=50)

    def reached(point: Point) -> float:
        preset = PRESETS["default"].changed(point)
        return objective(FixedTrial(point), preset, common, tmp_path / str(point["alpha"]))

    assert reached({**PAPER, **extreme}) < reached(PAPER) - 1 / 3


@pytest.mark.slow
def test_pruning_saves_ticks_at_equal_trials(spec: StudySpec) -> None:
    common = replace(SMALL, reports=5)
    whole = replace(spec, common=common)
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
    for trial, other in zip(with_all, without_some, strict=True):  # the same training, as far as it went
        assert other.intermediate_values.items() <= trial.intermediate_values.items()
