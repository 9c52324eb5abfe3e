"""Who explores, and how."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.algorithms.exploration import NO_TASK, Explorer, epsilon_at, random_tasks
from hexwar_sb3.errors import ConfigError

GAMES, PIECES, TASKS = 500, 4, 6


def masks(seed: int = 0) -> NDArray[np.bool_]:
    mask = np.random.default_rng(seed).random((GAMES, PIECES, TASKS)) < 0.4
    mask[..., 0] = True
    return mask


@pytest.mark.parametrize(
    ("episode", "epsilon"), [(0, 0.5), (99, 0.5), (100, 0.49), (450, 0.46), (4_500, 0.05), (9_000, 0.05)]
)
def test_the_papers_epsilon_falls_by_a_hundredth_every_hundred_episodes(episode: int, epsilon: float) -> None:
    """0.5, minus 0.01 every 100 episodes, until 0.05 (IV)."""
    assert epsilon_at(episode, 0.5, 0.05, 4_500, every=100) == pytest.approx(epsilon)


def test_random_tasks_are_valid_and_all_of_them_occur() -> None:
    mask = np.broadcast_to(np.array([True, False, True, True, False]), (3_000, 5))

    tasks = random_tasks(mask, np.random.default_rng(0))

    counts = np.bincount(tasks, minlength=5)
    assert counts[[1, 4]].sum() == 0
    assert (np.abs(counts[[0, 2, 3]] / 3_000 - 1 / 3) < 0.04).all()


def test_only_valid_tasks_are_played() -> None:
    mask, rng = masks(), np.random.default_rng(1)
    explorer = Explorer(GAMES, PIECES)
    current = np.full((GAMES, PIECES), NO_TASK)
    for step in range(20):
        mask = masks(step)
        current = explorer.choose(mask.argmax(axis=-1), current, mask, 0.5, rng)
        assert np.take_along_axis(mask, current[..., None], axis=-1).all()


def test_every_piece_of_every_game_draws_for_itself() -> None:
    """One coin for a whole batch, as SB3's DQN draws it, would let all explore or none."""
    explorer = Explorer(GAMES, PIECES)
    greedy = np.zeros((GAMES, PIECES), np.int64)

    explorer.choose(greedy, greedy - 1, masks(), 0.3, np.random.default_rng(0))

    assert explorer.exploring.mean() == pytest.approx(0.3, abs=0.04)
    assert 0.2 < explorer.exploring.any(axis=1).mean() < 0.95
    assert np.corrcoef(explorer.exploring.T)[0, 1] == pytest.approx(0.0, abs=0.15)


def test_without_epsilon_all_is_greedy() -> None:
    greedy = masks().argmax(axis=-1)

    tasks = Explorer(GAMES, PIECES).choose(greedy, greedy - 1, masks(), 0.0, np.random.default_rng(0))

    assert (tasks == greedy).all()


def test_an_exploring_piece_keeps_its_task_with_the_given_probability() -> None:
    mask = np.ones((GAMES, PIECES, TASKS), bool)
    explorer, rng = Explorer(GAMES, PIECES, stickiness=0.8), np.random.default_rng(0)
    greedy = np.zeros((GAMES, PIECES), np.int64)
    first = explorer.choose(greedy, greedy - 1, mask, 1.0, rng)

    explorer.choose(greedy, first, mask, 0.0, rng)

    assert explorer.exploring.mean() == pytest.approx(0.8, abs=0.03)


def test_a_task_that_is_gone_or_masked_is_not_kept() -> None:
    mask = np.ones((GAMES, PIECES, TASKS), bool)
    explorer, rng = Explorer(GAMES, PIECES, stickiness=0.999), np.random.default_rng(0)
    greedy = np.zeros((GAMES, PIECES), np.int64)
    first = explorer.choose(greedy, greedy - 1, mask, 1.0, rng)
    mask[np.arange(GAMES), 0, first[:, 0]] = False
    first[:, 1] = NO_TASK

    explorer.choose(greedy, first, mask, 0.0, rng)

    assert not explorer.exploring[:, :2].any()
    assert explorer.exploring[:, 2:].mean() > 0.9


def test_a_new_game_starts_without_kept_tasks() -> None:
    explorer = Explorer(GAMES, PIECES)
    explorer.exploring[:] = True

    explorer.end_games(np.arange(GAMES) < 10)

    assert explorer.exploring.any(axis=1).sum() == GAMES - 10


def test_stickiness_out_of_range_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"stickiness must be in \[0, 1\), got 1"):
        Explorer(1, 1, stickiness=1.0)
