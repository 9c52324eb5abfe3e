"""What one trial does: two levels in turn, reports in game ticks, a policy that is worth its objective."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import optuna
import pytest
from optuna.pruners import BasePruner, NopPruner
from optuna.trial import TrialState

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.tuning.objective import FORCE, Common, objective
from hexwar_sb3.tuning.space import PAPER, Point
from tests.tuning.conftest import SMALL


class Second(BasePruner):
    """Prunes at the second report."""

    def prune(self, study: optuna.Study, trial: optuna.trial.FrozenTrial) -> bool:
        return len(trial.intermediate_values) == 2


def one_trial(
    folder: Path, point: Point, common: Common = SMALL, pruner: BasePruner | None = None
) -> optuna.trial.FrozenTrial:
    study = optuna.create_study(direction="maximize", pruner=pruner or NopPruner())
    preset = PRESETS["default"].changed(point)
    study.optimize(lambda trial: objective(trial, preset, common, folder), n_trials=1)
    return study.trials[0]


Made = tuple[optuna.trial.FrozenTrial, Path]


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A whole trial of the paper's point, and its policy."""
    folder = tmp_path_factory.mktemp("paper") / "policy"
    return one_trial(folder, PAPER), folder


def test_a_trial_is_worth_the_mean_margin_of_its_policy(paper: Made) -> None:
    trial, folder = paper
    again = SMALL.judge(FrozenPolicy.load(folder), PRESETS["default"], SMALL.final_games)

    assert trial.value == again.mean_margin.value / FORCE
    assert trial.user_attrs["win_rate"] == again.win_rate.value


def test_reports_and_budget_are_game_ticks_of_both_levels(paper: Made) -> None:
    trial, _ = paper
    assert list(trial.intermediate_values) == [60_000 + 36_000, 60_000 + 72_000]
    assert trial.user_attrs["ticks"] == pytest.approx(SMALL.lower_ticks + SMALL.upper_ticks, rel=0.05)


def test_a_pruned_trial_saves_ticks_and_leaves_its_policy(paper: Made, tmp_path: Path) -> None:
    whole, _ = paper
    trial = one_trial(tmp_path / "policy", PAPER, pruner=Second())

    assert trial.state == TrialState.PRUNED
    assert trial.intermediate_values == whole.intermediate_values
    assert trial.user_attrs["ticks"] < 0.85 * whole.user_attrs["ticks"]
    assert FrozenPolicy.load(tmp_path / "policy").about["side"] == "both"


@pytest.mark.parametrize(
    "other", [{"alpha": 1.0}, {"beta": 0.5}, {"decision_ticks": 150}], ids=lambda point: next(iter(point))
)
def test_alpha_beta_and_delta_t_each_change_what_is_learned(
    other: Point, paper: Made, tmp_path: Path
) -> None:
    one_trial(tmp_path / "other", {**PAPER, **other})

    assert weights(tmp_path / "other" / "lower") != weights(paper[1] / "lower")


def weights(folder: Path) -> bytes:
    return (folder / "weights.safetensors").read_bytes()


WRONG: dict[str, Any] = {"lower_ticks": 0, "upper_ticks": -1, "reports": 0, "final_games": 2.5, "seed": 10**6}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_number_is_named(name: str) -> None:
    with pytest.raises(ConfigError, match=name):
        replace(SMALL, **{name: WRONG[name]})
