"""What one trial does: trainings of two levels, one a seed, a mean after each of them, policies that are worth it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Any

import optuna
import pytest
from optuna.pruners import BasePruner, NopPruner
from optuna.trial import TrialState

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.commands.tune import Tune
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.opponents import broad_mixture
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.tuning.objective import Common, new_model, objective, train_once
from hexwar_sb3.tuning.space import PAPER, Point
from tests.tuning.conftest import SMALL

DEFAULT = PRESETS["default"]


class After(BasePruner):
    """Prunes after a training, by its number."""

    def __init__(self, training: int) -> None:
        self.training = training

    def prune(self, study: optuna.Study, trial: optuna.trial.FrozenTrial) -> bool:
        return len(trial.intermediate_values) == self.training


def one_trial(folder: Path, pruner: BasePruner | None = None) -> optuna.trial.FrozenTrial:
    """A trial of the paper's point."""
    study = optuna.create_study(direction="maximize", pruner=pruner or NopPruner())
    preset = DEFAULT.changed(PAPER)
    study.optimize(lambda trial: objective(trial, preset, SMALL, folder), n_trials=1)
    return study.trials[0]


Made = tuple[optuna.trial.FrozenTrial, Path]


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A whole trial of the paper's point, and its policies."""
    folder = tmp_path_factory.mktemp("paper") / "policies"
    return one_trial(folder), folder


def test_a_trial_is_worth_the_mean_of_its_trainings_and_each_of_them_its_policy(paper: Made) -> None:
    trial, folder = paper
    again = [SMALL.judge(FrozenPolicy.load(folder / str(seed)), DEFAULT, seed) for seed in SMALL.seeds]
    margins = [one.mean_margin.value / 134 for one in again]

    assert trial.user_attrs["trainings"] == margins
    assert trial.value == fmean(margins)
    assert trial.user_attrs["win_rate"] == fmean(one.win_rate.value for one in again)
    assert trial.user_attrs["points_held"] == fmean(one.points_held.mean() for one in again)


def test_a_trial_reports_its_mean_so_far_after_each_training(paper: Made) -> None:
    trial, _ = paper
    first, second = trial.user_attrs["trainings"]

    assert first != second
    assert trial.intermediate_values == {1: first, 2: fmean([first, second])}


def test_the_budget_is_game_ticks_of_both_levels_of_all_trainings(paper: Made) -> None:
    assert SMALL.ticks == 2 * (SMALL.lower_ticks + SMALL.upper_ticks)
    assert paper[0].user_attrs["ticks"] == pytest.approx(SMALL.ticks, rel=0.05)


def test_a_pruned_trial_saves_whole_trainings_and_leaves_their_policies(paper: Made, tmp_path: Path) -> None:
    whole, _ = paper
    trial = one_trial(tmp_path / "policies", After(1))

    assert trial.state == TrialState.PRUNED
    assert trial.intermediate_values == {1: whole.intermediate_values[1]}
    assert trial.user_attrs["trainings"] == whole.user_attrs["trainings"][:1]
    assert trial.user_attrs["ticks"] == pytest.approx(SMALL.ticks / 2, rel=0.05)
    assert [path.name for path in (tmp_path / "policies").iterdir()] == ["0"]
    assert FrozenPolicy.load(tmp_path / "policies" / "0").about["seed"] == "0"


def test_a_trial_that_has_all_its_trainings_is_completed(tmp_path: Path) -> None:
    """A pruner has nothing to save any more."""
    assert one_trial(tmp_path / "policies", After(2)).state == TrialState.COMPLETE


def test_a_training_is_the_same_alone_and_after_others(paper: Made, tmp_path: Path) -> None:
    """So a policy of a study serves where its point is trained with this seed."""
    trial, folder = paper
    ticks: list[int] = []
    second = train_once(DEFAULT.changed(PAPER), SMALL, 1, tmp_path / "alone", ticks.append)

    assert second.margin == trial.user_attrs["trainings"][1]
    assert weights(tmp_path / "alone") == weights(folder / "1") != weights(folder / "0")
    assert ticks[0] < trial.user_attrs["ticks"]


@pytest.mark.parametrize(
    "other", [{"alpha": 1.0}, {"beta": 0.5}, {"decision_ticks": 150}], ids=lambda point: next(iter(point))
)
def test_alpha_beta_and_delta_t_each_change_what_the_lower_level_learns(other: Point, tmp_path: Path) -> None:
    """In games that are long enough for points to be won or lost: alpha weighs them."""
    common = replace(SMALL, lower_ticks=240_000, upper_ticks=1_800)
    for name, point in (("paper", PAPER), ("other", {**PAPER, **other})):
        train_once(DEFAULT.changed(point), common, 0, tmp_path / name)

    assert weights(tmp_path / "other" / "lower") != weights(tmp_path / "paper" / "lower")


def weights(folder: Path) -> bytes:
    return (folder / "weights.safetensors").read_bytes()


def test_opponents_are_met_by_weights_and_by_losses() -> None:
    common = replace(SMALL, opponents=("MA1=3", "nearest"))
    env = new_model(DEFAULT, common, 0).get_env()

    assert env is not None
    settings = env.get_attr("games")[0].settings
    assert settings.opponent == [("MA1", 3.0), ("nearest", 1.0)]
    assert settings.priority == DEFAULT.env["priority"] == 1.0


def test_the_command_has_the_defaults_of_a_study() -> None:
    command, common = vars(Tune()), vars(Common())

    assert command["opponents"] == ()
    assert common.pop("opponents") == broad_mixture("plain")
    assert {name: command[name] for name in common} == common


def test_seeds_of_a_study_are_one_a_training_and_fresh_ones_follow() -> None:
    common = Common(seed=3, trainings=2)

    assert [*common.seeds] == [3, 4]
    assert [*common.fresh_seeds] == [5, 6]


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no ticks": ({"lower_ticks": 0}, "lower_ticks"),
    "less than none": ({"upper_ticks": -1}, "upper_ticks"),
    "no training": ({"trainings": 0}, "trainings"),
    "half a game": ({"final_games": 2.5}, "final_games"),
    "a seed too high": ({"seed": 10**6}, "seed must be in"),
    "a last seed too high": ({"seed": 10**6 - 1}, r"seed must be in 0\.\.999999, got 1000000"),
    "no panel": ({"panel": ()}, "at least one player of the panel"),
    "an opponent twice": ({"opponents": ("MA1", "MA1=2")}, "named once, got 'MA1' again"),
    "a weight that is none": ({"opponents": ("MA1=1e999",)}, "NAME or NAME=WEIGHT"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_setting_is_named(what: str) -> None:
    settings, message = WRONG[what]
    with pytest.raises(ConfigError, match=message):
        replace(SMALL, **settings)
