"""Gymnasium's vector envs of the batched engine: the games of as many single envs, to the bit."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics

from hexwar_sb3.envs.registration import ENVS, FLAT_ENV, ROUTE_ENV, TASK_ENV
from hexwar_sb3.errors import ConfigError, UnknownNameError, UnknownSettingError

SHORT = {"decision_ticks": 300}  # a game is six decisions long
STEPS = {TASK_ENV: 15, FLAT_ENV: 90, ROUTE_ENV: 60}
SETTINGS: dict[str, dict[str, Any]] = {
    TASK_ENV: {**SHORT, "side": "both", "opponent": ["nearest", "random"], "warm_start": 0.5},
    FLAT_ENV: {**SHORT, "side": "both", "opponent": ["nearest", "random"]},
    ROUTE_ENV: {},
}


def batched(env_id: str, n: int, **settings: Any) -> Any:
    return gymnasium.make_vec(env_id, num_envs=n, vectorization_mode="vector_entry_point", **settings)


def one_by_one(env_id: str, n: int, **settings: Any) -> Any:
    modes = {"autoreset_mode": AutoresetMode.SAME_STEP}
    return gymnasium.make_vec(env_id, num_envs=n, vectorization_mode="sync", vector_kwargs=modes, **settings)


def same(one: object, other: object) -> bool:
    """Equal in kind, shape, type and bits; arrays of objects entry by entry."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray) and one.dtype == object:
        return all(same(a, b) for a, b in zip(one.tolist(), list(other), strict=True))  # type: ignore[call-overload]
    return data_equivalence(one, other, exact=True)


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("seed", [5, [7, 3, 7]])
def test_the_games_are_those_of_single_envs_of_the_same_seeds(env_id: str, seed: Any) -> None:
    """Observations, rewards, ends, infos and what they say of the last step: all that `SyncVectorEnv` gives."""
    mine, theirs = (make(env_id, 3, **SETTINGS[env_id]) for make in (batched, one_by_one))
    assert mine.observation_space == theirs.observation_space
    assert mine.action_space == theirs.action_space
    assert same(mine.reset(seed=seed), theirs.reset(seed=seed))
    mine.action_space.seed(0)
    ended = 0
    for _ in range(STEPS[env_id]):
        actions = mine.action_space.sample()
        got, expected = mine.step(actions), theirs.step(actions)
        assert same(got, expected)
        ended += int((got[2] | got[3]).sum())
    assert ended >= 3
    assert same(mine.reset(), theirs.reset())


def test_seeds_of_a_batch_are_its_first_ones() -> None:
    """Slot b of a large batch plays what slot b of a small one plays."""
    large, small = batched(TASK_ENV, 4, **SHORT), batched(TASK_ENV, 2, **SHORT)
    obs, few = large.reset(seed=9)[0], small.reset(seed=9)[0]
    assert all(np.array_equal(obs[key][:2], few[key]) for key in few)
    assert small.np_random_seed == 9


def test_observations_are_not_changed_by_later_steps() -> None:
    envs = batched(TASK_ENV, 2, **SHORT)
    obs, _ = envs.reset(seed=0)
    kept = {key: value.copy() for key, value in obs.items()}
    for _ in range(3):
        envs.step(np.zeros(envs.action_space.shape, np.int64))
    assert all(np.array_equal(obs[key], kept[key]) for key in kept)


def test_it_says_how_games_start_anew() -> None:
    envs = batched(TASK_ENV, 2)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert envs.spec is not None
    assert envs.spec.id == TASK_ENV
    assert type(gymnasium.make_vec(TASK_ENV, num_envs=2)) is type(envs)


def test_masks_are_those_of_the_single_envs() -> None:
    """By `call`, as with `SyncVectorEnv`, and as one array."""
    for env_id in ENVS:
        mine, theirs = batched(env_id, 2), one_by_one(env_id, 2)
        mine.reset(seed=1)
        theirs.reset(seed=1)
        expected = theirs.call("action_masks")
        assert same(mine.call("action_masks"), expected)
        assert np.array_equal(mine.action_masks(), np.stack(expected))
    assert mine.call("num_envs") == mine.get_attr("num_envs") == (2, 2)


def test_gymnasiums_own_wrapper_counts_the_episodes() -> None:
    envs = RecordEpisodeStatistics(batched(FLAT_ENV, 2, **SHORT))
    envs.reset(seed=0)
    ended = np.zeros(2, np.bool_)
    while not ended.any():
        _, _, ended, _, infos = envs.step(np.zeros(2, np.int64))
    assert (infos["episode"]["l"][ended] > 6).all()


def test_pictures_are_drawn_of_every_game() -> None:
    for env_id in ENVS:
        envs = batched(env_id, 2, render_mode="rgb_array")
        envs.reset(seed=0)
        first, second = envs.render()
        assert first.shape == second.shape
        assert first.dtype == np.uint8
    assert batched(TASK_ENV, 1).render() is None


def test_what_it_cannot_do_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"autoreset_mode .* 'SameStep', got 'NextStep'"):
        batched(TASK_ENV, 2, autoreset_mode="NextStep")
    with pytest.raises(UnknownNameError, match="rgb_array"):
        batched(TASK_ENV, 2, render_mode="ansi")
    with pytest.raises(UnknownSettingError, match="scenaro"):
        batched(TASK_ENV, 2, scenaro="plain")
    envs = batched(TASK_ENV, 2)
    with pytest.raises(ConfigError, match="a seed for each of 2 games, got 3"):
        envs.reset(seed=[1, 2, 3])
    with pytest.raises(ConfigError, match="seed must be"):
        envs.reset(seed=-1)
    with pytest.raises(ConfigError, match="reset_mask"):
        envs.reset(options={"reset_mask": np.ones(2, np.bool_)})
    envs.reset(seed=0)
    with pytest.raises(ConfigError, match=r"shape .*\(2, 7\)"):
        envs.step(np.zeros((3, 7), np.int64))
