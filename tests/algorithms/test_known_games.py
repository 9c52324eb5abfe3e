"""QMIX and VDN on games whose values are known (learning.md, section 4), through JointActionEnv, unchanged."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.replay import situation_of
from hexwar_sb3.envs.joint_action import JointActionEnv
from tests.envs.matrix_games import (
    CLIMBING,
    ONE_STEP,
    PENALTY,
    CueGame,
    MatrixGame,
    OwnPayGame,
    RepeatedGame,
    TwoStepGame,
)

# Q_Σ of (row, column) at 1, 2A and 2B with gamma 0.99 and random exploration (Rashid et al. 2018, table 1).
# VDN's best fit to 2B by least squares is [[-1.5, 2.5], [2.5, 6.5]].
QMIX_TABLES = [[[6.93, 6.93], [7.92, 7.92]], [[7.0, 7.0], [7.0, 7.0]], [[0.0, 1.0], [1.0, 8.0]]]
VDN_TABLES = [[[7.0, 7.0], [7.0, 7.0]], [[-1.5, 2.5], [2.5, 6.5]]]

TWO_STEP: dict[str, Any] = {
    "learning_rate": lambda left: 2e-3 * left,
    "batch_size": 64,
    "tau": 0.02,
    "n_steps": 1,
    "reward_scale": 1.0,
    "loss": "squared",
    "stickiness": 0.0,
    "exploration_initial_eps": 1.0,
    "exploration_final_eps": 1.0,
    "learning_starts": 100,
    "buffer_size": 5_000,
    "device": "cpu",
}
REPEATED: dict[str, Any] = {
    "n_steps": 3,
    "reward_scale": 10.0,
    "stickiness": 0.0,
    "exploration_initial_eps": 1.0,
    "exploration_final_eps": 0.05,
    "exploration_episodes": 1_000,
    "gradient_steps": 2,
    "device": "cpu",
}


@pytest.fixture(autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)


def games(make: Callable[[], MatrixGame]) -> VecEnv:
    return DummyVecEnv([lambda: Monitor(JointActionEnv(make()))] * 8)


def joint_values(model: QMIX) -> NDArray[np.float64]:
    """Q_Σ of every joint action at 1, 2A and 2B, in points."""
    env = JointActionEnv(TwoStepGame())
    tables = np.zeros((3, 2, 2))
    for place, row, column in np.ndindex(tables.shape):
        obs, _ = env.reset()
        if place:
            obs, *_ = env.step(np.array([place - 1, 0]))
        tables[place, row, column] = joint_value(model, obs, (row, column))
    return tables


def joint_value(model: QMIX, obs: dict[str, NDArray[Any]], actions: tuple[int, int]) -> float:
    seen = situation_of({key: value[None] for key, value in obs.items()}, model.device)
    with torch.no_grad():
        return float(model.learner.mixed_value(seen, torch.tensor(actions))[0, 0]) * model.scale


def greedy_return(model: QMIX, episodes: int = 8) -> float:
    assert model.env is not None
    return float(evaluate_policy(model, model.env, n_eval_episodes=episodes)[0])  # type: ignore[arg-type]


def check_two_step(mixer: str, seed: int, env_steps: int) -> None:
    """QMIX represents the game exactly; a sum of two functions comes no nearer, and loses 1 by it."""
    tables, accuracy, best = {"qmix": (QMIX_TABLES, 0.1, 8.0), "vdn": (VDN_TABLES, 0.35, 7.0)}[mixer]

    model = QMIX("TaskPolicy", games(TwoStepGame), mixer=mixer, seed=seed, **TWO_STEP).learn(env_steps)

    np.testing.assert_allclose(joint_values(model)[3 - len(tables) :], tables, atol=accuracy)
    assert greedy_return(model) == best


@pytest.mark.parametrize("mixer", ["qmix", "vdn"])
def test_the_two_step_game(mixer: str) -> None:
    check_two_step(mixer, seed=0, env_steps=2_400)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("mixer", ["qmix", "vdn"])
def test_the_two_step_game_with_three_more_seeds(mixer: str, seed: int) -> None:
    check_two_step(mixer, seed, env_steps=6_000)


def check_one_step(loss: str, seed: int) -> None:
    """No monotone table is the game's; one that forgives what turned out worse has its best in the right place."""
    learner = {**TWO_STEP, "learning_rate": 1e-3, "loss": loss, "seed": seed}

    model = QMIX("TaskPolicy", games(partial(RepeatedGame, ONE_STEP, 1)), mixer="ow-qmix", **learner)

    assert greedy_return(model.learn(2_400)) == 8.0


def test_the_one_step_game() -> None:
    check_one_step("squared", seed=0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("loss", ["squared", "huber"])
def test_the_one_step_game_with_three_more_seeds(loss: str, seed: int) -> None:
    check_one_step(loss, seed)


@pytest.mark.parametrize(("memory", "least", "most"), [("gru", 1.0, 1.0), (None, 0.0, 0.9)])
def test_who_remembers_the_cue_is_paid(memory: str | None, least: float, most: float) -> None:
    """Who does not cannot know: 1 of 2, or less."""
    learner = {
        **TWO_STEP,
        "learning_rate": 2e-3,
        "n_steps": 3,
        "td_lambda": 0.8,
        "exploration_final_eps": 0.3,
    }

    model = QMIX("TaskPolicy", games(CueGame), memory=memory, seed=0, **learner).learn(4_000)

    assert least <= greedy_return(model, episodes=40) <= most


@pytest.mark.parametrize("share_parameters", [True, False])
def test_each_learns_what_it_is_paid_itself(share_parameters: bool) -> None:
    """The mean of both pays, which others learn from, is 0.5 to 2 for either, whatever the other does."""
    learner = {**TWO_STEP, "mixer": "iql", "individual_rewards": True, "share_parameters": share_parameters}
    model = QMIX("TaskPolicy", games(OwnPayGame), seed=0, **learner).learn(1_600)
    obs, _ = JointActionEnv(OwnPayGame()).reset()
    seen = situation_of({key: value[None] for key, value in obs.items()}, model.device)

    for actions in ((0, 0), (1, 1)):
        with torch.no_grad():
            values = model.learner.mixed_value(seen, torch.tensor(actions))[0] * model.scale
        np.testing.assert_allclose(
            values, [pay[action] for pay, action in zip(OwnPayGame.PAY, actions, strict=True)], atol=0.1
        )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("payoffs", "at_least"), [(PENALTY, 250.0), (CLIMBING, 125.0)])
def test_repeated_matrix_games(payoffs: tuple[tuple[float, ...], ...], at_least: float, seed: int) -> None:
    """Penalty-0: all of 25 · 10; climbing: QMIX is known to stop short of 275 (Papoudakis et al. 2021)."""
    model = QMIX("TaskPolicy", games(partial(RepeatedGame, payoffs)), seed=seed, **REPEATED).learn(50_000)

    assert greedy_return(model) >= at_least
