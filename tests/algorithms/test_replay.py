"""The replay buffer: what comes out is what was put in, over one step and over several."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.algorithms.checkpoint_arrays import write_arrays
from hexwar_sb3.algorithms.replay import StepReplay
from hexwar_sb3.errors import ConfigError, TrainingError

GAMES, PIECES, TASKS = 2, 2, 3
CPU = torch.device("cpu")


def space(bound: float = 1.0) -> spaces.Dict:
    """Task env whose obs is the moment, whose tasks are numbered."""
    return spaces.Dict(
        {
            "obs": spaces.Box(-bound, bound, (PIECES, 1)),
            "tasks": spaces.Box(-bound, bound, (PIECES, TASKS, 1)),
            "action_mask": spaces.Box(0, 1, (PIECES, TASKS), np.int8),
            "alive": spaces.Box(0.0, 1.0, (PIECES,)),
        }
    )


def replay(rows: int = 20, bound: float = 64.0) -> StepReplay:
    return StepReplay(
        rows * GAMES, space(bound), spaces.MultiDiscrete([TASKS] * PIECES), CPU, GAMES, gamma=0.5
    )


def observe(moment: int) -> dict[str, NDArray[Any]]:
    """Everything that is seen at a moment says which moment it is."""
    mask = np.ones((GAMES, PIECES, TASKS), np.int8)
    mask[:, :, 2] = moment % 2
    return {
        "obs": np.full((GAMES, PIECES, 1), moment, np.float32),
        "tasks": np.full((GAMES, PIECES, TASKS, 1), moment, np.float32) * mask[..., None],
        "action_mask": mask,
        "alive": np.ones((GAMES, PIECES), np.float32),
    }


def add(
    buffer: StepReplay,
    moment: int,
    *,
    done: bool = False,
    cut: bool = False,
    info: dict[str, Any] | None = None,
) -> None:
    """Store the step from `moment` to the next; its reward is the moment."""
    infos = [{"TimeLimit.truncated": cut, **(info or {})} for _ in range(GAMES)]
    tasks = np.full((GAMES, PIECES), moment % 2)
    reward = np.full(GAMES, moment, np.float32)
    buffer.add(observe(moment), observe(moment + 1), tasks, reward, np.full(GAMES, done), infos)


def moments(batch_obs: torch.Tensor) -> list[int]:
    return [int(value) for value in batch_obs[::PIECES, 0]]


def test_one_step_leads_to_the_next_moment() -> None:
    buffer = replay()
    for moment in range(1, 6):
        add(buffer, moment)

    batch = buffer.sample(200, 1, np.random.default_rng(0))

    now, then = moments(batch.now.sets.obs), moments(batch.then.sets.obs)
    assert set(now) == {1, 2, 3, 4, 5}
    assert then == [moment + 1 for moment in now]
    assert batch.reward.flatten().tolist() == now
    assert batch.tasks[::PIECES].tolist() == [moment % 2 for moment in now]
    assert set(batch.discount.flatten().tolist()) == {0.5}


@pytest.mark.parametrize("moments_before", [0, 37])
def test_new_steps_are_drawn_more_often(moments_before: int) -> None:
    """The age of a step is u^2 of what is kept, wherever the ring begins."""
    buffer = replay(rows=101, bound=1000.0)
    for moment in range(moments_before + 100):
        add(buffer, moment)
    newest = moments_before + 99

    found = moments(buffer.sample(20_000, 1, np.random.default_rng(0)).now.sets.obs)

    ages = newest - np.array(found)
    assert set(ages.tolist()) == set(range(100))
    for share in (0.1, 0.25, 0.5):
        assert (ages < 100 * share).mean() == pytest.approx(share**0.5, abs=0.02)


@pytest.mark.parametrize("next_row", [5, 39])
def test_all_that_was_stored_is_drawn_from_a_larger_replay(next_row: int) -> None:
    """A ring that had gone round lies in a part of the larger one; a file may name any row as the next."""
    small, large = replay(rows=20), replay(rows=40)
    for moment in range(25):
        add(small, moment)
    parts = {name: np.asarray(array) for name, array in small.snapshot().items()}
    if next_row != small.next_row[0]:
        parts["next_row"] = np.full(GAMES, next_row)

    large.restore(parts)

    drawn = moments(large.sample(5_000, 1, np.random.default_rng(0)).now.sets.obs)
    assert set(drawn) == set(range(6, 25))


def test_three_steps_add_up_their_discounted_rewards() -> None:
    """From moment m: m + 0.5 (m + 1) + 0.25 (m + 2), then 0.125 of moment m + 3; less at the newest row."""
    buffer = replay()
    for moment in range(1, 6):
        add(buffer, moment)

    batch = buffer.sample(200, 3, np.random.default_rng(0))

    now, then = np.array(moments(batch.now.sets.obs)), np.array(moments(batch.then.sets.obs))
    whole = now <= 3
    assert (then == np.minimum(now + 3, 6)).all()
    np.testing.assert_allclose(batch.reward.flatten().numpy()[whole], 1.75 * now[whole] + 1.0)
    np.testing.assert_allclose(batch.discount.flatten().numpy(), 0.5 ** (then - now))


def test_steps_do_not_run_on_into_the_next_game() -> None:
    buffer = replay()
    for moment in range(1, 4):
        add(buffer, moment, done=moment == 3)
    for moment in range(11, 14):
        add(buffer, moment)

    batch = buffer.sample(200, 5, np.random.default_rng(0))

    now = np.array(moments(batch.now.sets.obs))
    ended = batch.terminated.flatten().numpy() == 1
    assert (ended == (now <= 3)).all()
    assert batch.reward.flatten().numpy()[now == 2].tolist() == pytest.approx([3.5] * int((now == 2).sum()))


def test_a_game_that_was_cut_short_goes_on_in_the_mind() -> None:
    """Truncated is not terminated: the value of the last observation still counts."""
    buffer = replay()
    for moment in range(1, 4):
        add(buffer, moment, done=moment == 3, cut=moment == 3)
    add(buffer, 11)

    batch = buffer.sample(200, 5, np.random.default_rng(0))

    now, then = np.array(moments(batch.now.sets.obs)), np.array(moments(batch.then.sets.obs))
    assert set(now) == {1, 2, 3, 11}
    assert (then[now <= 3] == 4).all()
    assert not batch.terminated.any()


def test_a_reset_between_two_steps_ends_the_running_games() -> None:
    buffer = replay()
    add(buffer, 1)
    add(buffer, 2)
    buffer.cut_short()
    add(buffer, 11)

    batch = buffer.sample(100, 5, np.random.default_rng(0))

    now, then = np.array(moments(batch.now.sets.obs)), np.array(moments(batch.then.sets.obs))
    assert (then[now <= 2] == 3).all()
    assert (then[now == 11] == 12).all()


def test_the_oldest_steps_make_room() -> None:
    buffer = replay(rows=6)
    for moment in range(1, 21):
        add(buffer, moment, done=moment % 4 == 0)

    batch = buffer.sample(400, 3, np.random.default_rng(0))

    now, then = np.array(moments(batch.now.sets.obs)), np.array(moments(batch.then.sets.obs))
    assert len(buffer) == 5 * GAMES
    assert set(now) == {16, 17, 18, 19, 20}
    assert ((then - now) <= 3).all()
    assert (then[now == 17] == 20).all()


def test_only_valid_tasks_are_drawn() -> None:
    buffer = replay()
    for moment in range(1, 5):
        add(buffer, moment)

    sets = buffer.sample(50, 1, np.random.default_rng(0)).now.sets

    moment_of_row = sets.obs[sets.piece, 0]
    assert (sets.tasks[:, 0] == moment_of_row).all()
    assert (moment_of_row[sets.task == 2] % 2 == 1).all()
    assert len(sets.piece) == int((2 + sets.obs[:, 0] % 2).sum())


def test_windows_are_single_steps_in_a_row() -> None:
    buffer = replay()
    for moment in range(1, 7):
        add(buffer, moment, done=moment == 3)

    batch = buffer.sample_windows(40, 3, np.random.default_rng(0))

    now = np.array(moments(batch.now.sets.obs)).reshape(40, 3)
    inside = batch.inside.numpy().reshape(40, 3)
    assert inside[:, 0].all()
    for row, mask in zip(now, inside, strict=True):
        assert (np.diff(row[mask]) == 1).all()
        assert not (row[mask] <= 3).any() or not (row[mask] > 3).any()


def test_windows_that_reach_back_begin_where_their_game_does() -> None:
    """As far as the step that was drawn is still in them: games of three steps and of four."""
    buffer = replay()
    for moment in range(1, 8):
        add(buffer, moment, done=moment in (3, 7))

    def begins(length: int) -> set[int]:
        batch = buffer.sample_windows(200, length, np.random.default_rng(0), reach_back=True)
        return set(np.array(moments(batch.now.sets.obs)).reshape(200, length)[:, 0].tolist())

    assert begins(4) == {1, 4}
    assert begins(2) == {1, 2, 4, 5, 6}


def test_the_discount_follows_the_ticks_of_the_decision() -> None:
    buffer = replay()
    add(buffer, 1, info={"ticks": 150})

    assert buffer.sample(1, 1, np.random.default_rng(0)).discount.item() == 0.25


def test_a_demonstration_replaces_the_stored_tasks() -> None:
    """What another player did in the learner's seat is what was done."""
    buffer = replay()
    add(buffer, 1, info={"demo_actions": np.array([2, 0])})

    assert buffer.sample(1, 1, np.random.default_rng(0)).tasks.tolist() == [2, 0]


@pytest.mark.parametrize("task", [2, 3, -1])
def test_a_masked_demonstration_is_refused(task: int) -> None:
    with pytest.raises(TrainingError, match="a masked task was played or demonstrated"):
        add(replay(), 2, info={"demo_actions": np.array([task, 0])})


def test_nothing_can_be_drawn_from_an_empty_buffer() -> None:
    with pytest.raises(ConfigError, match="the replay buffer is empty"):
        replay().sample(1, 1, np.random.default_rng(0))


def test_masked_rows_are_not_kept() -> None:
    buffer = replay()
    for moment in (1, 2):  # all three tasks are valid at odd moments, two at even ones
        add(buffer, moment)

    assert [len(rows) for rows in buffer.sets if len(rows)] == [6, 4, 6] * GAMES


def test_only_small_features_are_stored_in_half_precision() -> None:
    assert replay(bound=1.0).sets[0].dtype == np.float16
    assert replay(bound=1e5).sets[0].dtype == np.float32


def test_a_snapshot_of_other_games_or_too_large_is_refused() -> None:
    buffer = replay()
    add(buffer, 1)
    parts = buffer.snapshot()

    games = {**parts, "done": np.zeros((len(parts["done"]) + 1, 1), np.bool_)}
    rows = {**parts, "done": np.zeros((len(parts["done"]), 999), np.bool_)}
    for broken in (games, rows):
        with pytest.raises(ConfigError, match="the stored replay holds"):
            buffer.restore(broken)


def test_a_snapshot_is_written_as_numpy_writes_it() -> None:
    buffer, mine, numpys = replay(), io.BytesIO(), io.BytesIO()
    for moment in range(1, 9):
        add(buffer, moment)
    write_arrays(mine, buffer.snapshot())
    np.savez(numpys, **buffer.snapshot())
    for file in (mine, numpys):
        file.seek(0)

    with np.load(mine, allow_pickle=False) as found, np.load(numpys, allow_pickle=False) as expected:
        assert found.files == expected.files
        for name in found.files:
            assert found[name].dtype == expected[name].dtype
            np.testing.assert_array_equal(found[name], expected[name])


def test_what_was_in_a_buffer_is_gone_after_a_restore() -> None:
    short, long = replay(), replay()
    add(short, 1)
    for moment in range(1, 9):
        add(long, moment)

    long.restore(short.snapshot())

    assert len(long) == len(short)


@pytest.mark.parametrize("steps", [3, 19, 20, 45])
def test_a_snapshot_restores_everything(steps: int) -> None:
    buffer, other = replay(), replay()
    for moment in range(1, 1 + steps):
        add(buffer, moment % 50, done=moment % 5 == 0)

    other.restore(buffer.snapshot())
    add(buffer, 7)
    add(other, 7)

    mine, theirs = (one.sample(64, 3, np.random.default_rng(0)) for one in (buffer, other))
    assert len(buffer) == len(other)
    torch.testing.assert_close(mine.now.sets.tasks, theirs.now.sets.tasks, rtol=0, atol=0)
    torch.testing.assert_close(mine.then.sets.obs, theirs.then.sets.obs, rtol=0, atol=0)
    torch.testing.assert_close(mine.reward, theirs.reward, rtol=0, atol=0)
