"""Samplers by name, drawn as a study draws; pruners that compare trials over equal seeds."""

from __future__ import annotations

from typing import Any

import optuna
import pytest

from hexwar_sb3.tuning.samplers import SAMPLERS, make_sampler
from hexwar_sb3.tuning.space import Point, space_of
from hexwar_sb3.tuning.study import PRUNERS, suggest
from hexwar_sb3.tuning.workers import comes_again

SPACE = space_of(("mixer", "spots"))


def draw(study: optuna.Study, sampler: str, seed: int = 0) -> Point:
    """One trial, as a process of its own makes it; its value is a slope in alpha."""
    study.sampler = make_sampler(sampler, seed)
    trial = study.ask()
    point = {name: suggest(trial, name, one) for name, one in SPACE.items()}
    study.tell(trial, -point["alpha"])
    return point


def new_study(**how: Any) -> optuna.Study:
    return optuna.create_study(direction="maximize", **how)


@pytest.mark.parametrize("name", SAMPLERS)
def test_every_sampler_draws_points_of_the_space(name: str) -> None:
    study = new_study()
    points = [draw(study, name) for _ in range(14)]  # past the beginning, which is random

    assert len({point["alpha"] for point in points}) >= 13
    assert [draw(again, name) for again in [new_study()] for _ in range(14)] == points


def test_neighbouring_seeds_share_no_trial() -> None:
    alphas = [
        {draw(study, "random", seed)["alpha"] for study in [new_study()] for _ in range(8)} for seed in (0, 1)
    ]
    assert not alphas[0] & alphas[1]


@pytest.mark.parametrize("name", ["tpe", "random"])
def test_a_study_whose_trial_died_draws_on_as_an_unbroken_one(name: str) -> None:
    whole = new_study()
    points = [draw(whole, name) for _ in range(13)]

    study = new_study()
    drawn = [draw(study, name) for _ in range(4)]
    study.sampler = make_sampler(name, 0)
    dead = study.ask()
    for key, one in SPACE.items():
        suggest(dead, key, one)
    study.tell(dead, state=optuna.trial.TrialState.FAIL)
    comes_again(study, study.trials[-1])
    drawn += [draw(study, name) for _ in range(9)]

    assert drawn == points


def test_a_trial_that_died_at_once_keeps_the_point_that_it_was_given() -> None:
    study = new_study()
    study.enqueue_trial({"alpha": 0.25, "spots": 3})
    trial = study.ask()
    trial.suggest_int("spots", 2, 12)
    study.tell(trial, state=optuna.trial.TrialState.FAIL)
    comes_again(study, study.trials[0])

    assert study.trials[1].system_attrs["fixed_params"] == {"alpha": 0.25, "spots": 3}


def raced(study: optuna.Study, *means: float) -> int:
    """Trainings after which a trial with these means so far is broken off; all of them if it is not."""
    trial = study.ask()
    for step, mean in enumerate(means, start=1):
        trial.report(mean, step)
        if trial.should_prune():
            study.tell(trial, state=optuna.trial.TrialState.PRUNED)
            return step
    study.tell(trial, means[-1])
    return len(means)


def test_halving_compares_after_the_first_training_and_those_that_came_as_far() -> None:
    study = new_study(pruner=PRUNERS["halving"]())

    assert raced(study, 0.5, 0.9, 0.8) == 3  # the first has nobody beside it
    assert raced(study, 0.4, 9.0, 9.0) == 1
    assert raced(study, 0.7, 0.6, 0.6) == 2  # ahead of the first after one, behind it after two
    assert raced(study, 0.6, 1.0, 1.0) == 3  # the second of four: the better half
    assert raced(study, 0.5, 9.0, 9.0) == 1  # the third of five


def test_the_median_is_that_of_completed_trials_after_as_many_trainings() -> None:
    study = new_study(pruner=PRUNERS["median"]())
    for level in (0.1, 0.2, 0.3, 0.4, 0.5):
        assert raced(study, level, 1.0 + level, 1.0) == 3  # five are completed first

    assert raced(study, 0.29, 9.0, 9.0) == 1
    assert raced(study, 0.31, 1.29, 9.0) == 2
    assert raced(study, 0.31, 1.31, 1.31) == 3


def test_no_pruner_prunes_nothing() -> None:
    study = new_study(pruner=PRUNERS["none"]())
    for level in (1.0,) * 6 + (0.0,):
        assert raced(study, level, level) == 2
