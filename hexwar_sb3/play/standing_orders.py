"""Standing orders: a policy some of whose pieces hold one spot from some tick on, whatever it says itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.lower_policy import Lower
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.tasks.features import PER_GAME, index, sizes
from hexwar_sb3.tasks.records import TaskKind

LEAD = 0.5
"""Scaled points by which an ordered task counts for more than any other: a student learns it sharply."""
_TIME_LEFT = index("obs", 1, 1, 1)["game: time left"].start - sizes(1, 1, 1).obs
"""Place of a feature of own pieces, counted from the end: what is of the game stands last, in every scenario."""

Observation = Mapping[str, NDArray[Any]]


def ticks_left(obs: Observation) -> NDArray[np.int64]:
    """Ticks until the end of each game [n]."""
    return np.rint(obs["obs"][..., _TIME_LEFT].max(axis=1) / PER_GAME).astype(np.int64)


@dataclass(frozen=True, kw_only=True)
class StandingOrder:
    """Some pieces hold one spot."""

    pieces: tuple[int, ...]  # slots of the camp
    spot: int  # its place among the spots that a piece can hold, in the order of its task set
    ticks_left: int  # of the game, at most; before that the policy is free

    def rows(self, obs: Observation) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.int64]]]:
        """Each piece, the games [n] in which it can follow the order now, and the task that it is there [n]."""
        now = ticks_left(obs) <= self.ticks_left
        for piece in self.pieces:
            holds = (obs["tasks"][:, piece, :, TaskKind.HOLD] > 0) & (obs["action_mask"][:, piece] != 0)
            wanted = holds & (holds.cumsum(axis=1) == self.spot + 1)
            games = np.flatnonzero(wanted.any(axis=1) & now)
            yield piece, games, wanted[games].argmax(axis=1)


@dataclass(frozen=True)
class LedPolicy:
    """A policy that follows an order: a player, and a teacher."""

    policy: FrozenPolicy
    order: StandingOrder

    @property
    def lower(self) -> Lower:
        """Who leads its pieces on their way."""
        return self.policy.lower

    def reset(self) -> None:
        """Nothing to forget: it acts on the present observation alone."""

    def act(self, obs: Observation) -> NDArray[np.int64]:
        """Task indices [B, N]."""
        tasks = self.policy.act(obs)
        for piece, games, ordered in self.order.rows(obs):
            tasks[games, piece] = ordered
        return tasks

    def q_values(self, obs: Observation) -> NDArray[np.float32]:
        """Q of every task [B, N, K], in scaled points; an ordered one leads by LEAD."""
        q = self.policy.q_values(obs)
        for piece, games, ordered in self.order.rows(obs):
            q[games, piece, ordered] = q[games, piece].max(axis=1) + LEAD
        return q


def standing_orders(scenario: Scenario, camp: Camp, spots: int, free_ticks: int) -> list[StandingOrder]:
    """Every order to a squad of vehicles: all tanks, all chariots or both, or the first of each.

    Soldiers ride with them, so an order to a soldier changes little.

    Args:
        scenario: of the games.
        camp: who is ordered.
        spots: how many there are, control points and hot spots.
        free_ticks: from the start of the game, in which the policy does as it likes.
    """
    own = [piece.kind for piece in scenario.pieces if piece.camp == camp]
    tanks, chariots = (
        tuple(i for i, kind in enumerate(own) if kind == wanted)
        for wanted in (PieceType.TANK, PieceType.CHARIOT)
    )
    whole = [tanks, chariots, (*tanks, *chariots)]
    firsts = [tanks[:1], chariots[:1], (*tanks[:1], *chariots[:1])]
    squads = [squad for squad in dict.fromkeys([*whole, *firsts]) if squad]
    return [
        StandingOrder(pieces=squad, spot=spot, ticks_left=scenario.game_ticks - free_ticks)
        for squad in squads
        for spot in range(spots)
    ]
