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
from stable_baselines3.common.env_util import make_vec_env as make_stock_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.envs.task_env import TaskEnv
from hexwar_sb3.errors import ConfigError, UnknownNameError

SHORT = 300  # Delta-t: a game in six decisions


def test_gymnasium_finds_nothing_wrong() -> None:
    check_gymnasium(gymnasium.make(TASK_ENV, decision_ticks=SHORT).unwrapped)


@pytest.mark.filterwarnings("ignore:.*seems that your observation .* is an image:UserWarning")
@pytest.mark.filterwarnings("ignore:.*minimal resolution for an image:UserWarning")
@pytest.mark.filterwarnings("ignore:.*has an unconventional shape:UserWarning")
def test_stable_baselines3_finds_nothing_wrong() -> None:
    """Task rows have three axes and masks two, on purpose: SB3 only warns."""
    check_sb3(TaskEnv(decision_ticks=SHORT))


def test_it_draws_what_the_learner_knows_on_request() -> None:
    env = TaskEnv(render_mode="rgb_array", decision_ticks=SHORT)
    env.reset(seed=0)
    start = env.render()
    assert start is not None
    assert start.dtype == np.uint8
    assert start.ndim == 3
    for _ in range(3):
        env.step(env.games.sight.obs["action_mask"][0].argmax(axis=-1) * 0 + 1)
    later = env.render()
    assert later is not None
    assert (start != later).any()
    assert TaskEnv(decision_ticks=SHORT).render() is None


def test_an_unknown_render_mode_is_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown render_mode 'human'"):
        TaskEnv(render_mode="human")


def test_stable_baselines3_makes_it_by_its_id() -> None:
    """SB3 asks for a picture of every env that it makes itself."""
    env = make_stock_vec_env(TASK_ENV, n_envs=2, env_kwargs={"decision_ticks": SHORT})
    assert env.reset()["obs"].shape[0] == 2  # type: ignore[call-overload]


@pytest.mark.parametrize("actions", [np.zeros((1, 400), int), np.zeros(3, int), np.zeros((7, 1)), None])
def test_actions_of_another_shape_are_refused(actions: Any) -> None:
    env, batch = TaskEnv(decision_ticks=SHORT), make_vec_env(TASK_ENV, decision_ticks=SHORT)
    env.reset(seed=0)
    batch.reset()
    for step in (env.step, batch.step):
        with pytest.raises(
            ConfigError, match=r"actions must be whole numbers of shape \(games, pieces\) = \(1, 7\)"
        ):
            step(actions)


def test_an_opponent_with_actions_of_another_shape_is_refused() -> None:
    class Wrong:
        def act(self, obs: Any) -> NDArray[np.int64]:
            return np.zeros(3, np.int64)

    env = TaskEnv(decision_ticks=SHORT, opponent=Wrong())
    env.reset(seed=0)
    with pytest.raises(ConfigError, match=r"of shape \(games, pieces\) = \(1, 7\), got int64 \(3,\)"):
        env.step(np.zeros(7, np.int64))


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
