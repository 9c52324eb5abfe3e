"""A replay whose transitions have lengths of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.algorithms.timed_replay import TimedReplayBuffer
from hexwar_sb3.errors import CheckpointError, ConfigError, TrainingError

Obs = dict[str, NDArray[Any]]


def small_replay(n_envs: int, rows: int = 5) -> TimedReplayBuffer:
    space = spaces.Dict({"cell": spaces.Box(0.0, 9.0, (2,)), "action_mask": spaces.Box(0, 1, (3,), np.int8)})
    return TimedReplayBuffer(rows * n_envs, space, spaces.Discrete(3), "cpu", n_envs, gamma=0.5)


def row(n_envs: int, reward: float = 0.0) -> tuple[Obs, Obs, NDArray[Any], NDArray[Any], NDArray[Any]]:
    obs = {"cell": np.full((n_envs, 2), reward), "action_mask": np.ones((n_envs, 3))}
    next_obs = {**obs, "cell": obs["cell"] + 1.0}
    return obs, next_obs, np.ones((n_envs, 1)), np.full(n_envs, reward), np.zeros(n_envs)


def test_a_transition_without_a_length_takes_one_unit_of_time() -> None:
    replay = small_replay(2)
    replay.add(*row(2), [{}, {"steps": 3.0}])

    discounts = replay.sample(50).discounts

    assert discounts is not None
    assert sorted(set(discounts.flatten().tolist())) == [0.125, 0.5]


@pytest.mark.parametrize("steps", [-1.0, float("nan"), float("inf")])
def test_a_length_that_is_none_is_refused(steps: float) -> None:
    with pytest.raises(TrainingError, match="must be finite and at least 0, got"):
        small_replay(2).add(*row(2), [{"steps": steps}, {}])


def test_no_return_crosses_a_reset() -> None:
    replay = small_replay(1)
    replay.n_steps = 2
    replay.cut_short()  # nothing is running yet
    for reward in (1.0, 10.0):
        replay.add(*row(1, reward=reward), [{}])
        replay.cut_short()

    sample = replay.sample(50)

    assert sorted(set(sample.rewards.flatten().tolist())) == [1.0, 10.0]
    assert not sample.dones.any()


@pytest.mark.parametrize("written", [3, 5, 7], ids=["part", "full", "over"])
def test_a_replay_comes_back_with_the_rows_that_were_written(written: int) -> None:
    replay, other = small_replay(2), small_replay(2)
    for k in range(written):
        replay.add(*row(2, reward=k), [{"steps": k}] * 2)

    parts = replay.snapshot()
    other.restore(parts)
    for each in (replay, other):
        each.add(*row(2, reward=99.0), [{}] * 2)

    assert len(parts["rewards"]) == len(parts["obs_cell"]) == min(written, 5)
    assert (other.pos, other.full) == (replay.pos, replay.full)
    for name, array in replay.snapshot().items():
        np.testing.assert_array_equal(other.snapshot()[name], array)


def test_a_sample_keeps_what_belongs_together() -> None:
    replay = small_replay(2)
    for k in range(7):
        replay.add(*row(2, reward=k), [{"steps": k}] * 2)

    batch = replay.sample(64)

    assert batch.discounts is not None
    assert set(batch.rewards.flatten().tolist()) == {2.0, 3.0, 4.0, 5.0, 6.0}
    np.testing.assert_array_equal(batch.discounts, 0.5**batch.rewards)
    np.testing.assert_array_equal(batch.observations["cell"], batch.rewards.repeat(1, 2))
    np.testing.assert_array_equal(batch.next_observations["cell"], batch.rewards.repeat(1, 2) + 1.0)


def test_a_replay_of_other_envs_or_too_large_is_refused() -> None:
    replay = small_replay(2)
    for _ in range(5):
        replay.add(*row(2), [{}] * 2)

    with pytest.raises(ConfigError, match="holds 5 transitions of 2 envs, this one has room for 5 of 4"):
        small_replay(4).restore(replay.snapshot())
    with pytest.raises(ConfigError, match="room for 3 of 2"):
        small_replay(2, rows=3).restore(replay.snapshot())


def test_a_full_replay_goes_into_a_larger_one() -> None:
    replay, larger = small_replay(2), small_replay(2, rows=9)
    for k in range(7):
        replay.add(*row(2, reward=k), [{}] * 2)

    larger.restore(replay.snapshot())
    larger.add(*row(2, reward=7.0), [{}] * 2)

    assert sorted(larger.snapshot()["rewards"][:, 0].tolist()) == [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


WRONG = {"nan": np.nan, "inf": np.inf, "least": -np.inf, "huge": 1e30}


def test_every_array_of_a_stored_replay_is_checked() -> None:
    """Numbers that are none, out of range, of another type or shape; nothing is taken over then."""
    replay, other = small_replay(2), small_replay(2)
    for k in range(3):
        replay.add(*row(2, reward=k), [{"steps": k}] * 2)
    parts = replay.snapshot()
    for name, array in parts.items():
        broken: list[Any] = [array.astype(np.float16), array[None], np.full(array.shape, "x"), None]
        if array.dtype.kind == "f":
            broken += [np.full_like(array, value) for value in WRONG.values()]
        else:
            broken += [
                np.full_like(array, np.iinfo(array.dtype).min),
                np.full_like(array, np.iinfo(array.dtype).max),
            ]
        for one in broken:
            with pytest.raises((CheckpointError, ConfigError)):
                other.restore({**parts, name: one})
        with pytest.raises(CheckpointError, match=f"no '{name}'"):
            other.restore({key: value for key, value in parts.items() if key != name})
    assert other.size() == 0
    other.restore(parts)
    assert other.size() == 3
