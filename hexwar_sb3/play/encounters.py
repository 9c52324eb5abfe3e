"""Who is met how often: opponents that beat the learner come more often (PFSP: Vinyals et al. 2019, methods)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.bots.registry import FAMILIES, MOST_MEMBER
from hexwar_sb3.engine.fields import check_form, check_range
from hexwar_sb3.play.seeds import episode_draw
from hexwar_sb3.players.player import BotPlayer, Seat

MEMORY = 64  # games that a running win rate looks back on
FLOOR = 0.1  # of its weight, with which an opponent that always loses is met all the same
KEPT = 32  # members of a family that are remembered, those that beat the learner last
AGAIN = 0.5  # of the games with a family, those against such a member, if there is one
_MEMBER_STREAM = 4  # of an episode's draws
_MOST_GAMES = 1 << 40


class Encounters:
    """Games against each of some opponents, and how they went.

    Args:
        players: number of opponents.
        priority: exponent of the learner's share of losses; 0: all are as urgent, members of a family too.
    """

    def __init__(self, players: int, priority: float = 0.0) -> None:
        self.priority = priority
        self.games = np.zeros(players, np.int64)  # that ended [n]
        self.rates = np.full(players, 0.5)  # running win rate of the learner, draws count half [n]
        self.beaten_by: list[list[int]] = [[] for _ in range(players)]  # members of a family, the latest last

    def seat(self, opponent: int, player: Seat, seed: int, episode: int) -> Seat:
        """Who plays for an opponent: itself; of a family a new member, or one that beat the learner when they met last."""
        if not (self.priority and isinstance(player, BotPlayer) and player.name in FAMILIES):
            return player
        known, rng = self.beaten_by[opponent], episode_draw(seed, episode, _MEMBER_STREAM)
        if known and rng.random() < AGAIN:
            return replace(player, member=known[rng.integers(len(known))])
        return replace(player, member=int(rng.integers(1, MOST_MEMBER, endpoint=True)))

    def note(self, opponent: int, win: float, member: int = 0) -> None:
        """Count a game: 1 for a win of the learner, 0.5 for a draw, 0 for a loss.

        Args:
            opponent: its place.
            win: of the learner.
            member: of a family, which is remembered while it wins; 0: of none.
        """
        self.games[opponent] += 1
        known = self.beaten_by[opponent]
        if member not in known:  # those that come again because they won would tell less of the whole family
            # The first games move it from one half at once.
            share = 1.0 / min(self.games[opponent] + 1, MEMORY)
            self.rates[opponent] += share * (win - self.rates[opponent])
        if member:
            others = [one for one in known if one != member]
            self.beaten_by[opponent] = [*others, *([member] if win == 0.0 else [])][-KEPT:]

    def take(self, opponent: int, other: Encounters, known_as: int) -> None:
        """Go on with what others counted of the same player."""
        self.games[opponent], self.rates[opponent] = other.games[known_as], other.rates[known_as]
        self.beaten_by[opponent] = other.beaten_by[known_as]

    @property
    def urgency(self) -> NDArray[np.float64]:
        """Factor of each opponent's weight [n]."""
        return np.maximum((1.0 - self.rates) ** self.priority, FLOOR)

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What has been counted, for a checkpoint."""
        members = np.array([[0] * (KEPT - len(one)) + one for one in self.beaten_by], np.uint32)
        return {"met": self.games.copy(), "rates": self.rates.copy(), "beaten_by": members}

    def check(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Check what `snapshot` gave; later opponents may have come since.

        Raises:
            CheckpointError: it is broken, or of more opponents.
        """
        met: Any = parts["met"]  # of a file
        known = min(len(met), len(self.games)) if np.ndim(met) == 1 else 0
        check_form("met", met, np.int64, (known,))
        check_form("rates", parts["rates"], np.float64, (known,))
        check_form("beaten_by", parts["beaten_by"], np.uint32, (known, KEPT))
        check_range("met", met, 0, _MOST_GAMES)
        check_range("rates", parts["rates"], 0.0, 1.0)

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave, and `check` has seen; of later opponents nothing is known."""
        self.games[:], self.rates[:] = 0, 0.5
        for own, kept in ((self.games, parts["met"]), (self.rates, parts["rates"])):
            own[: len(kept)] = kept
        later = len(self.games) - len(parts["met"])
        self.beaten_by = [[m for m in row if m] for row in parts["beaten_by"].tolist()] + [
            [] for _ in range(later)
        ]
