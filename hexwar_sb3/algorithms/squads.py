"""Squad orders as exploration: some pieces hold one spot together for a while, whatever the network says.

Pieces that explore each for itself never do so by chance, and off-policy learning can read what it is worth.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.fields import check_form, check_names, check_range
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.features import feature_index, sizes
from hexwar_sb3.tasks.records import TaskKind

LAST_START = 15  # an order begins after 0 to so many decisions
LENGTHS = (6, 23)  # and lasts so many
_TYPES = feature_index("obs", 1, 1, 1)["self: type"]
_HOLD = feature_index("row", 1, 1, 1)["task: kind"].start + TaskKind.HOLD
_MOST_DECISIONS = 1 << 30


@lru_cache
def squads_of(kinds: tuple[int, ...]) -> NDArray[np.bool_]:
    """Squads of a line-up [S, N]: its tanks, its chariots, both, the first of each, the first two, everybody."""
    own = np.array(kinds)
    tanks, chariots = own == PieceType.TANK, own == PieceType.CHARIOT
    first = [squad & (squad.cumsum() == 1) for squad in (tanks, chariots)]
    squads = [tanks, chariots, tanks | chariots, *first, first[0] | first[1], np.ones(len(own), bool)]
    return np.unique([squad for squad in squads if squad.any()], axis=0)


def check_ordered(shapes: TaskShapes) -> None:
    """Check that pieces of an env with these sizes can be ordered: it is the task env.

    Raises:
        ConfigError: it is another.
    """
    if shapes.task_dim != sizes(1, 1, 1).row:
        raise ConfigError(
            "squad orders are for the task env: leave squad_initial_share and squad_final_share at 0"
        )


class SquadOrders:
    """Orders of some games at a time.

    Args:
        n_envs: games at a time.
        n_pieces: pieces of a camp.
    """

    def __init__(self, n_envs: int, n_pieces: int) -> None:
        self.members = np.zeros((n_envs, n_pieces), bool)  # who is ordered in each game [B, N]
        self.spot = np.zeros(n_envs, np.int64)  # place of the ordered spot among those that can be held [B]
        self.first = np.zeros(n_envs, np.int64)  # decision at which the order begins [B]
        self.end = np.zeros(n_envs, np.int64)  # and the one at which it is over [B]
        self.decision = np.zeros(n_envs, np.int64)  # of each game [B]

    def lead(
        self,
        tasks: NDArray[np.int64],
        obs: Mapping[str, NDArray[Any]],
        share: float,
        rng: np.random.Generator,
    ) -> NDArray[np.int64]:
        """Tasks [B, N] in which the ordered pieces hold their spot, where they can.

        Args:
            tasks: what the pieces would do otherwise [B, N].
            obs: of the task env, a batch.
            share: of the games that begin now, which get an order.
            rng: five draws are taken for each game that begins.
        """
        self._draw(np.flatnonzero(self.decision == 0), obs, share, rng)
        ordered = np.flatnonzero((self.decision >= self.first) & (self.decision < self.end))
        self.decision += 1
        if not ordered.size:
            return tasks
        holds = (obs["tasks"][ordered, :, :, _HOLD] > 0) & (obs["action_mask"][ordered] != 0)
        wanted = holds & (holds.cumsum(axis=2) == self.spot[ordered, None, None] + 1)
        follows = self.members[ordered] & wanted.any(axis=2)
        led = tasks.copy()
        led[ordered] = np.where(follows, wanted.argmax(axis=2), tasks[ordered])
        return led

    def _draw(
        self,
        games: NDArray[np.int64],
        obs: Mapping[str, NDArray[Any]],
        share: float,
        rng: np.random.Generator,
    ) -> None:
        """Draw orders for games that begin."""
        for b, (ordered, squad, spot, start, length) in zip(games, rng.random((len(games), 5)), strict=True):
            squads = squads_of(tuple(obs["obs"][b, :, _TYPES].argmax(axis=1).tolist()))
            holds = (obs["tasks"][b, :, :, _HOLD] > 0) & (obs["action_mask"][b] != 0)
            self.members[b] = squads[int(squad * len(squads))]
            self.spot[b] = int(spot * holds.sum(axis=1).max())
            self.first[b] = int(start * (LAST_START + 1))
            lasts = LENGTHS[0] + int(length * (LENGTHS[1] - LENGTHS[0] + 1))
            self.end[b] = self.first[b] + (lasts if ordered < share else 0)

    def end_games(self, dones: NDArray[np.bool_]) -> None:
        """New games begin where `dones` [B]."""
        self.decision[dones] = 0

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """Everything, for a checkpoint."""
        return dict(vars(self))

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            CheckpointError: it is broken.
        """
        own = self.snapshot()
        check_names(parts, own)
        for name, array in own.items():
            check_form(name, parts[name], array.dtype, array.shape)
            if name != "members":
                check_range(name, parts[name], 0, _MOST_DECISIONS)
        for name, array in own.items():
            array[...] = parts[name]
