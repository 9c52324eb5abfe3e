"""Exploration: each piece of each game draws for itself, among its valid tasks, and sticks to its task."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, TrainingError

NO_TASK = -1  # in `current`: the task under way is not in the new task set


def epsilon_at(episode: int, initial: float, final: float, episodes: int, every: int = 1) -> float:
    """Probability of a random task after some finished episodes.

    A function of the number of episodes, which is saved with the model: SB3's schedules follow the
    progress of one call of `learn`, and jump up again on resume. The paper: 0.5, minus 0.01 every 100
    episodes, down to 0.05 (IV), which is (0.5, 0.05, 4500, 100).

    Args:
        episode: finished episodes.
        initial: at the start.
        final: after `episodes`, and from then on.
        episodes: until the final value is reached.
        every: episodes between two steps down.

    Example:
        >>> epsilon_at(199, 0.5, 0.05, 4500, every=100)
        0.49
    """
    return initial + (final - initial) * min(1.0, episode // every * every / episodes)


def random_tasks(mask: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.int64]:
    """Draw a valid task for every piece, uniformly: mask [..., K] -> [...]."""
    rank = (rng.random(mask.shape[:-1]) * mask.sum(axis=-1)).astype(np.int64)
    return np.asarray((mask.cumsum(axis=-1) > rank[..., None]).argmax(axis=-1))


def checked_masks(masks: NDArray[Any]) -> NDArray[np.bool_]:
    """Masks as booleans.

    Raises:
        TrainingError: a wrapper changed them.
    """
    if not np.isin(masks, (0, 1)).all():
        raise TrainingError(
            "the masks hold more than 0 and 1: a wrapper changed them, and must leave them as the env gives them"
        )
    return np.asarray(masks, bool)


class Explorer:
    """Epsilon-greedy choice that sticks: an exploring piece keeps its random task for a while.

    Args:
        n_envs: games at a time.
        n_pieces: pieces of a camp.
        stickiness: probability that an exploring piece keeps its random task at a decision.
    """

    def __init__(self, n_envs: int, n_pieces: int, stickiness: float = 0.8) -> None:
        if not 0.0 <= stickiness < 1.0:
            raise ConfigError(f"stickiness must be in [0, 1), got {stickiness}")
        self.stickiness = stickiness
        self.exploring = np.zeros((n_envs, n_pieces), dtype=bool)

    def choose(
        self,
        greedy: NDArray[np.int64],
        current: NDArray[np.int64],
        mask: NDArray[np.bool_],
        epsilon: float,
        rng: np.random.Generator,
    ) -> NDArray[np.int64]:
        """Pick a task for every piece.

        Args:
            greedy: best task of every piece [B, N].
            current: row of the task under way in the new task set, or NO_TASK [B, N].
            mask: valid tasks [B, N, K].
            epsilon: probability of a new random task.
            rng: three draws are taken for each piece.
        """
        valid = np.take_along_axis(mask, np.maximum(current, 0)[..., None], axis=-1)[..., 0] & (
            current != NO_TASK
        )
        kept = self.exploring & valid & (rng.random(greedy.shape) < self.stickiness)
        fresh = ~kept & (rng.random(greedy.shape) < epsilon)
        self.exploring = kept | fresh
        return np.where(kept, current, np.where(fresh, random_tasks(mask, rng), greedy))

    def end_games(self, dones: NDArray[np.bool_]) -> None:
        """Forget the tasks of the games that ended [B]."""
        self.exploring[dones] = False
