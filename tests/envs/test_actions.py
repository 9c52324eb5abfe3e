"""What is no action is refused in words by every env, before anything is played."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
import pytest

from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import ENVS, TASK_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError, UnknownNameError

NAN = float("nan")
ONE: list[Any] = [
    2.9,
    2.0,
    "2",
    NAN,
    True,
    None,
    [1, 2],
    np.float32(1),
    np.zeros(3, np.int64),
    [[1], [1, 2]],
    {},
    2**70,
]


def action(env_id: str, one: Any) -> Any:
    """An action that consists of this one, for one game."""
    return [one] * 7 if env_id == TASK_ENV else one


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("one", ONE)
def test_single_and_native_envs_take_whole_numbers_alone(env_id: str, one: Any) -> None:
    env, batch = gymnasium.make(env_id).unwrapped, make_vec_env(env_id, seed=0)
    env.reset(seed=0)
    batch.reset()
    with pytest.raises(ConfigError, match="actions must be whole numbers of shape"):
        env.step(action(env_id, one))
    with pytest.raises(ConfigError, match="actions must be whole numbers of shape"):
        batch.step(cast("Any", [action(env_id, one)]))


@pytest.mark.parametrize("env_id", ENVS)
def test_a_step_before_the_first_reset_is_refused(env_id: str) -> None:
    env, batch = gymnasium.make(env_id).unwrapped, make_vec_env(env_id, seed=0)
    with pytest.raises(ConfigError, match="reset the env before the first step"):
        env.step(action(env_id, 0))
    with pytest.raises(ConfigError, match="reset the env before the first step"):
        batch.unwrapped.step(np.array([action(env_id, 0)]))


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("one", [-1, 10**6, np.int8(-3), np.uint64(2**63)])
def test_an_action_out_of_range_stands_for_stop_or_staying(env_id: str, one: Any) -> None:
    """As the envs say: it is counted, and does what the first action does."""
    env, other = (gymnasium.make(env_id).unwrapped for _ in range(2))
    env.reset(seed=0)
    other.reset(seed=0)
    obs, reward, *_, info = env.step(action(env_id, one))
    same, its, *_ = other.step(action(env_id, 0))
    parts, others = (o.values() if isinstance(o, dict) else [o] for o in (obs, same))
    assert all(np.array_equal(a, b) for a, b in zip(parts, others, strict=True))
    assert reward == its
    assert info.get("illegal_actions", 1) > 0


@pytest.mark.parametrize("one", ONE)
def test_parallel_agents_act_by_whole_numbers_alone(one: Any) -> None:
    env = parallel_env("plain", "red", decision_ticks=300)
    with pytest.raises(ConfigError, match="reset the env before the first step"):
        env.step({"red:tank0": 0})
    env.reset(seed=0)
    with pytest.raises(ConfigError, match=r"agent 'red:tank0': actions must be whole numbers of shape \(\)"):
        env.step({"red:tank0": one})


def test_parallel_agents_that_do_not_exist_are_named() -> None:
    env = parallel_env("plain", "red", decision_ticks=300)
    env.reset(seed=0)
    for name in ("red:tank9", "blue:tank0", 3):
        with pytest.raises(UnknownNameError, match="unknown agent"):
            env.step({name: 0})  # type: ignore[dict-item]


def test_dead_and_silent_parallel_agents_change_nothing() -> None:
    """One without an action stops; of one that has left the action is not looked at."""
    games = [parallel_env("plain", "red", decision_ticks=300) for _ in range(2)]
    for env in games:
        env.reset(seed=0)
        env.arena.state.pieces[0, 0].blood = 0
        env.step({})
    left, right = (
        env.step(act) for env, act in zip(games, ({"red:tank0": cast("int", 2.9)}, {}), strict=True)
    )
    assert "red:tank0" not in games[0].agents
    assert left[1] == right[1]
    assert all(np.array_equal(left[0][a]["observation"], right[0][a]["observation"]) for a in right[0])
