"""The single env passes the checkers of its two houses, and stock learners run on it."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as check_gymnasium
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.callbacks import MaskableEvalCallback
from stable_baselines3.common.env_checker import check_env as check_sb3
from stable_baselines3.common.evaluation import evaluate_policy

from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.envs.task_env import TaskEnv

SHORT = 300  # Delta-t: a game in six decisions


def test_gymnasium_finds_nothing_wrong() -> None:
    check_gymnasium(gymnasium.make(TASK_ENV, decision_ticks=SHORT).unwrapped)


@pytest.mark.filterwarnings("ignore:.*seems that your observation .* is an image:UserWarning")
@pytest.mark.filterwarnings("ignore:.*minimal resolution for an image:UserWarning")
@pytest.mark.filterwarnings("ignore:.*has an unconventional shape:UserWarning")
def test_stable_baselines3_finds_nothing_wrong() -> None:
    """Task rows have three axes and masks two, on purpose: SB3 only warns."""
    check_sb3(TaskEnv(decision_ticks=SHORT))


def test_the_single_env_is_the_vec_env_of_one_game() -> None:
    env, batch = TaskEnv(decision_ticks=SHORT), make_vec_env(TASK_ENV, decision_ticks=SHORT, seed=3)
    obs, _ = env.reset(seed=3)
    batch_obs: Any = batch.reset()
    action = np.zeros(obs["action_mask"].shape[0], np.int64)
    over = False
    while not over:
        assert np.array_equal(obs["obs"], batch_obs["obs"][0])
        obs, reward, over, truncated, _ = env.step(action)
        batch_obs, rewards, dones, infos = batch.step(action[None])
        assert (reward, over, truncated) == (rewards[0], dones[0], False)
    assert np.array_equal(obs["obs"], infos[0]["terminal_observation"]["obs"])


class Stopper:
    """Model: stops everything."""

    def predict(self, obs: Any, **_: Any) -> tuple[NDArray[np.int64], None]:
        return np.zeros(obs["action_mask"].shape[:2], np.int64), None


def test_evaluate_policy_of_sb3_takes_it() -> None:
    env = make_vec_env(TASK_ENV, n_envs=2, decision_ticks=SHORT)
    returns, lengths = evaluate_policy(Stopper(), env, n_eval_episodes=2, return_episode_rewards=True)  # type: ignore[arg-type]
    assert isinstance(lengths, list)
    assert lengths == [6, 6]
    assert isinstance(returns, list)


def test_stock_maskable_ppo_learns_and_plays() -> None:
    """sb3-contrib unchanged, masks through VecMonitor; no `state` among its features."""
    env, judge = (make_vec_env(TASK_ENV, n_envs=2, decision_ticks=SHORT, seed=s) for s in (0, 1))
    model = MaskablePPO(
        "MultiInputPolicy", env, n_steps=6, batch_size=12, n_epochs=1, seed=0, policy_kwargs={"net_arch": [8]}
    )
    model.learn(24, callback=MaskableEvalCallback(judge, n_eval_episodes=2, eval_freq=6, verbose=0))
    assert "state" not in model.policy.observation_space.spaces  # type: ignore[attr-defined]

    rival = make_vec_env(TASK_ENV, decision_ticks=SHORT, opponent=model)
    rival.reset()
    _, _, _, infos = rival.step(np.zeros((1, *env.action_space.shape), np.int64))  # type: ignore[misc]
    assert infos[0]["ticks"] == SHORT
