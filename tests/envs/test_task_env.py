"""The single env passes the checkers of its two houses, and stock learners run on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

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
from hexwar_sb3.envs.task_vec_env import TaskVecEnv
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.players.frozen_lower import FORMAT, SIZES, FrozenLower

SHORT = 300  # Delta-t: a game in six decisions


def test_gymnasium_finds_nothing_wrong() -> None:
    check_gymnasium(gymnasium.make(TASK_ENV, decision_ticks=SHORT).unwrapped, skip_render_check=True)


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
    with pytest.raises(UnknownNameError, match="unknown render_mode 'ansi'"):
        TaskEnv(render_mode="ansi")


def test_stable_baselines3_makes_it_by_its_id() -> None:
    """SB3 asks for a picture of every env that it makes itself."""
    env = make_stock_vec_env(TASK_ENV, n_envs=2, env_kwargs={"decision_ticks": SHORT})
    assert env.reset()["obs"].shape[0] == 2  # type: ignore[call-overload]


@pytest.mark.parametrize("actions", [np.zeros((1, 400), int), np.zeros(3, int), np.zeros((7, 1)), None])
def test_actions_of_another_shape_are_refused(actions: Any) -> None:
    env, batch = TaskEnv(decision_ticks=SHORT), make_vec_env(TASK_ENV, decision_ticks=SHORT, seed=0)
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
    env = make_vec_env(TASK_ENV, n_envs=2, decision_ticks=SHORT, seed=0)
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

    rival = make_vec_env(TASK_ENV, decision_ticks=SHORT, opponent=model, seed=0)
    rival.reset()
    _, _, _, infos = rival.step(np.zeros((1, *env.action_space.shape), np.int64))  # type: ignore[misc]
    assert infos[0]["ticks"] == SHORT


def first_valid(_: NDArray[np.float32], masks: NDArray[np.int8]) -> NDArray[np.int64]:
    """Lower level that always heads the same way."""
    return masks.argmax(axis=1)


def random_lower(seed: int = 0) -> FrozenLower:
    rng = np.random.default_rng(seed)
    shapes = {name: [SIZES[axis] for axis in axes] for name, axes in FORMAT.layers.items()}
    return FrozenLower({name: rng.normal(size=shape).astype(np.float32) for name, shape in shapes.items()})


def lower_env(lower: object, seed: int = 3) -> TaskVecEnv:
    batch = make_vec_env(TASK_ENV, 2, seed=seed, decision_ticks=SHORT, lower=lower, side="both")
    return cast("TaskVecEnv", batch.unwrapped)


@pytest.mark.parametrize("make_lower", [lambda: first_valid, random_lower], ids=["callable", "network"])
def test_a_lower_level_leads_the_learners_pieces_also_after_a_restore(
    make_lower: Callable[[], Any], pick: Callable[[Any, int], NDArray[np.int64]]
) -> None:
    """Not as the heuristic does; and a game goes on the same in another env, whose network is another object."""
    env, other, plain = lower_env(make_lower()), lower_env(random_lower(1), seed=9), lower_env("heuristic")
    obs, plain_obs, differs = env.reset(), plain.reset(), False
    for step in range(12):
        if step == 2:
            other.reset()
            other.set_lower(make_lower())  # the second network that this one has known
            restored = other.restore(env.snapshot())
        obs, rewards, *_ = cast("Any", env.step(pick(obs["action_mask"], step)))
        plain_obs, *_ = cast("Any", plain.step(pick(plain_obs["action_mask"], step)))
        differs = differs or not np.array_equal(obs["obs"], plain_obs["obs"])
        if step >= 2:
            restored, others, *_ = cast("Any", other.step(pick(restored["action_mask"], step)))
            assert rewards.tolist() == others.tolist()
            assert all(np.array_equal(obs[key], restored[key]) for key in obs)
    assert differs


@pytest.mark.parametrize("lower", [first_valid, random_lower()], ids=["callable", "network"])
def test_a_lower_level_can_be_set_in_the_middle_of_a_game(lower: Any) -> None:
    """From then on it leads, and "heuristic" takes over again."""
    env, other = TaskEnv(decision_ticks=SHORT), TaskEnv(decision_ticks=SHORT, lower=lower)
    env.set_lower(lower)
    other.set_lower(lower)
    games = [env.reset(seed=1)[0], other.reset(seed=1)[0]]
    for _ in range(3):
        games = [one.step(np.ones(7, np.int64))[0] for one in (env, other)]
        assert np.array_equal(games[0]["obs"], games[1]["obs"])
    other.set_lower("heuristic")
    games = [one.step(np.full(7, 2))[0] for one in (env, other)]
    assert not np.array_equal(games[0]["obs"], games[1]["obs"])


def test_an_unknown_lower_level_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown lower 'heuristc'; did you mean 'heuristic'"):
        TaskEnv(lower="heuristc")


def test_the_choice_of_the_reward_changes_nothing_that_is_observed(
    pick: Callable[[Any, int], NDArray[np.int64]],
) -> None:
    """The margin that a camp knows is eq. (1) in both: a policy that learned by the one plays by the other."""
    envs = [
        make_vec_env(TASK_ENV, decision_ticks=SHORT, reward=reward, seed=0) for reward in ("net", "paper")
    ]
    net, paper = (cast("Any", env.reset()) for env in envs)
    rewards = []
    for step in range(6):
        assert all(np.array_equal(net[key], paper[key]) for key in net)
        (net, one, *_), (paper, other, *_) = (
            cast("Any", env.step(pick(obs["action_mask"], step)))
            for env, obs in zip(envs, (net, paper), strict=True)
        )
        rewards.append((float(one[0]), float(other[0])))
    assert any(one != other for one, other in rewards)
