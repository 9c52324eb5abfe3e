"""Envs that nobody seeded play games of their own; a seed is a game, and a bad one is refused at once."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv

from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import ENVS, FLAT_ENV, ROUTE_ENV, TASK_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError

STEPS = {TASK_ENV: 3, ROUTE_ENV: 6, FLAT_ENV: 30}
WRONG: list[Any] = [-1, True, 2.0, "1", float("nan"), 2**63, [1]]


def story(env: Any, steps: int, **reset: Any) -> list[bytes]:
    """What is seen of a game under the first valid actions."""
    obs, _ = env.reset(**reset)
    lines = []
    for _ in range(steps):
        lines.append(
            b"".join(
                np.asarray(part).tobytes() for part in (obs.values() if isinstance(obs, dict) else [obs])
            )
        )
        masks = env.unwrapped.action_masks()
        valid = masks.reshape(7, -1) if isinstance(obs, dict) and "tasks" in obs else masks
        obs, *_ = env.step(valid.argmax(axis=-1))
    return lines


def dice(env: Any) -> int:
    """Seed of the dice of the game under way."""
    games = env.games if hasattr(env, "games") else env.venv.fields[0]
    return int(games.arena.state.games.seed[0])


@pytest.mark.parametrize("env_id", ENVS)
def test_envs_that_nobody_seeded_are_different_games(env_id: str) -> None:
    """As Gymnasium's do: the first reset without a seed draws one."""
    envs = [gymnasium.make(env_id, side="red") for _ in range(3)]
    for env in envs:
        env.reset()
    assert len({dice(env.unwrapped) for env in envs}) > 1


@pytest.mark.parametrize("env_id", ENVS)
def test_a_drawn_seed_can_be_read_and_gives_the_same_game_again(env_id: str) -> None:
    env, other = gymnasium.make(env_id), gymnasium.make(env_id)
    drawn = env.unwrapped.np_random_seed
    assert story(env, STEPS[env_id]) == story(other, STEPS[env_id], seed=drawn)


@pytest.mark.parametrize("env_id", ENVS)
def test_a_seed_is_a_game_and_later_resets_go_on(env_id: str) -> None:
    env, other = gymnasium.make(env_id), gymnasium.make(env_id)
    first, second = story(env, STEPS[env_id], seed=np.int64(5)), story(env, STEPS[env_id])
    assert first == story(other, STEPS[env_id], seed=5)
    assert second == story(other, STEPS[env_id])
    assert env.unwrapped.np_random.random() == other.unwrapped.np_random.random()


@pytest.mark.parametrize("env_id", ENVS)
def test_native_envs_draw_a_seed_too_where_none_is_given(env_id: str) -> None:
    drawn = {make_vec_env(env_id).unwrapped.seed(None)[0] for _ in range(4)}
    assert len(drawn) > 1
    envs: list[Any] = [make_vec_env(env_id).unwrapped for _ in range(4)]
    firsts = {env.first_seed if env_id == ROUTE_ENV else env.games.first_seed for env in envs}
    assert len(firsts) > 1


def test_parallel_envs_that_nobody_seeded_are_different_games() -> None:
    envs = [parallel_env("plain", decision_ticks=300) for _ in range(3)]
    for env in envs:
        env.reset()
    assert len({int(env.arena.state.games.seed[0]) for env in envs}) > 1


def test_stock_envs_side_by_side_are_not_one_game() -> None:
    batch = DummyVecEnv([lambda: gymnasium.make(TASK_ENV) for _ in range(4)])
    batch.reset()
    games = {dice(env.unwrapped) for env in batch.envs}
    assert len(games) > 1


def make_single(env_id: str) -> Any:
    return gymnasium.make(env_id).unwrapped


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("seed", WRONG)
def test_a_seed_that_is_none_is_refused_at_once(seed: Any, env_id: str) -> None:
    env, batch = make_single(env_id), make_vec_env(env_id, seed=0)
    for give in (
        lambda: make_vec_env(env_id, seed=seed),
        lambda: batch.seed(seed),
        lambda: env.reset(seed=seed),
    ):
        with pytest.raises(ConfigError, match="seed must be"):
            give()


@pytest.mark.parametrize("seed", WRONG)
def test_parallel_envs_refuse_it_too(seed: Any) -> None:
    with pytest.raises(ConfigError, match="seed must be"):
        parallel_env().reset(seed=seed)
