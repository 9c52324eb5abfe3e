"""Who is met how often: opponents that beat the learner come more often (PFSP: Vinyals et al. 2019, methods)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.fields import check_form, check_range

MEMORY = 64  # games that a running win rate looks back on
FLOOR = 0.1  # of its weight, with which an opponent that always loses is met all the same
_MOST_GAMES = 1 << 40


class Encounters:
    """Games against each of some opponents, and how they went.

    Args:
        players: number of opponents.
        priority: exponent of the learner's share of losses; 0: all are as urgent.
    """

    def __init__(self, players: int, priority: float = 0.0) -> None:
        self.priority = priority
        self.games = np.zeros(players, np.int64)  # that ended [n]
        self.rates = np.full(players, 0.5)  # running win rate of the learner, draws count half [n]

    def note(self, opponent: int, win: float) -> None:
        """Count a game: 1 for a win of the learner, 0.5 for a draw, 0 for a loss."""
        self.games[opponent] += 1
        share = 1.0 / min(self.games[opponent] + 1, MEMORY)  # the first games move it from one half at once
        self.rates[opponent] += share * (win - self.rates[opponent])

    def take(self, opponent: int, other: Encounters, known_as: int) -> None:
        """Go on with what others counted of the same player."""
        self.games[opponent], self.rates[opponent] = other.games[known_as], other.rates[known_as]

    @property
    def urgency(self) -> NDArray[np.float64]:
        """Factor of each opponent's weight [n]."""
        return np.maximum((1.0 - self.rates) ** self.priority, FLOOR)

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What has been counted, for a checkpoint."""
        return {"met": self.games.copy(), "rates": self.rates.copy()}

    def check(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Check what `snapshot` gave; later opponents may have come since.

        Raises:
            CheckpointError: it is broken, or of more opponents.
        """
        met: Any = parts["met"]  # of a file
        known = min(len(met), len(self.games)) if np.ndim(met) == 1 else 0
        check_form("met", met, np.int64, (known,))
        check_form("rates", parts["rates"], np.float64, (known,))
        check_range("met", met, 0, _MOST_GAMES)
        check_range("rates", parts["rates"], 0.0, 1.0)

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave, and `check` has seen; of later opponents nothing is known."""
        self.games[:], self.rates[:] = 0, 0.5
        for own, kept in ((self.games, parts["met"]), (self.rates, parts["rates"])):
            own[: len(kept)] = kept
