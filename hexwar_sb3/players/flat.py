"""Play of a model that decides for one piece at a time: a task and a direction in one action (`HexWarFlat-v0`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.tasks.route import N_ANSWERS


def flat_observation(
    obs: Mapping[str, NDArray[Any]], games: NDArray[np.int64], slots: NDArray[np.int64]
) -> NDArray[Any]:
    """What piece slots[k] of game games[k] sees, in one row: its o, which tells its slot, and its task rows.

    Args:
        obs: observations of the task level, [games, ...].
        games, slots: [n].

    Returns:
        Rows [n, Do + K * Dt]; rows of masked tasks are 0.
    """
    own, tasks = obs["obs"][games, slots], obs["tasks"][games, slots]
    return np.concatenate([own, tasks.reshape(len(games), -1)], axis=1)


def is_flat(model: object) -> bool:
    """The model reads one vector: it was trained on the flat env."""
    shape = getattr(getattr(model, "observation_space", None), "shape", None)
    return shape is not None and len(shape) == 1


def predicted(model: Any, obs: Any, **masks: Any) -> object:
    """What a model's `predict` picks, greedily.

    Raises:
        ConfigError: it returns anything else than (actions, state).
    """
    answer = model.predict(obs, deterministic=True, **masks)
    if not (isinstance(answer, tuple) and len(answer) == 2):
        raise ConfigError(
            f"{type(model).__name__}.predict must return (actions, state), got {type(answer).__name__}"
        )
    return answer[0]


class FlatPlayer:
    """A model of the flat env as a player: it is asked for every living piece, greedily.

    Args:
        model: has `predict(rows [n, width], deterministic=True) -> (actions [n], state)`, actions as in the flat env.
    """

    def __init__(self, model: Any) -> None:
        self.model = model
        self.answers = np.zeros((0, 0), np.int64)

    def reset(self) -> None:
        """Nothing to forget."""

    def act(self, obs: Mapping[str, NDArray[Any]]) -> NDArray[np.int64]:
        """Task indices [games, pieces]; `answers` keeps the directions that go with them."""
        actions = np.zeros(obs["alive"].shape, np.int64)
        games, slots = np.nonzero(obs["alive"])
        if games.size:
            found = np.asarray(predicted(self.model, flat_observation(obs, games, slots)))
            if found.shape != games.shape or found.dtype.kind not in "iu":
                raise ConfigError(
                    f"{type(self.model).__name__}.predict must give {games.size} whole numbers, one a row,"
                    f" got {found.dtype} {found.shape}"
                )
            actions[games, slots] = found
        tasks, self.answers = np.divmod(actions, N_ANSWERS)
        return tasks
