"""What each finished game was expected to bring, beside what it brought."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.algorithms.td_targets import row_discount
from hexwar_sb3.players.terms import DECISION_TICKS


class GameLog:
    """Discounted return of every running game, and the value that was predicted at its start.

    Args:
        n_envs: games at a time.
        gamma: discount of 75 ticks.
    """

    def __init__(self, n_envs: int, gamma: float) -> None:
        self.gamma = gamma
        self.returns, self.discounts = np.zeros(n_envs), np.ones(n_envs)
        self.predicted = np.full(n_envs, np.nan)  # unknown for a game that was resumed half-way
        self.starting = np.ones(n_envs, dtype=bool)

    def predict(self, q_total: NDArray[np.floating[Any]]) -> None:
        """Note the predicted value of the games that are about to start [B], in points."""
        self.predicted[self.starting] = q_total[self.starting]
        self.starting[:] = False

    def add(
        self, rewards: NDArray[np.float32], dones: NDArray[np.bool_], infos: list[dict[str, Any]]
    ) -> NDArray[np.float64]:
        """Count a step; gives (predicted, returned) of the games that ended with it [ended, 2]."""
        self.returns += self.discounts * rewards
        self.discounts *= [row_discount(self.gamma, info.get("ticks", DECISION_TICKS)) for info in infos]
        ended = np.stack([self.predicted, self.returns], axis=1)[dones & ~np.isnan(self.predicted)]
        self.returns[dones], self.discounts[dones], self.starting[dones] = 0.0, 1.0, True
        return ended
