"""What a match gives back: one row a game, and the figures with their intervals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hexwar_sb3.evaluation.intervals import Estimate, mean_interval, wilson


@dataclass(frozen=True, eq=False)
class CampResult:
    """The games of a match as one camp saw them end.

    Attributes:
        scores: 1 won, 0.5 drawn, 0 lost, [game].
        margins: margin of eq. (1) at the end, in points [game].
        points_held: control points held at the end [game].
    """

    scores: npt.NDArray[np.float64]
    margins: npt.NDArray[np.float64]
    points_held: npt.NDArray[np.int64]

    @property
    def games(self) -> int:
        """Number of games."""
        return int(self.scores.size)

    @property
    def wins(self) -> int:
        """Number of games won."""
        return int((self.scores == 1).sum())

    @property
    def draws(self) -> int:
        """Number of games drawn."""
        return int((self.scores == 0.5).sum())

    @property
    def losses(self) -> int:
        """Number of games lost."""
        return self.games - self.wins - self.draws

    @property
    def win_rate(self) -> Estimate:
        """(wins + draws / 2) / games with its Wilson interval, in 0..1."""
        return wilson(float(self.scores.sum()), self.games)

    @property
    def mean_margin(self) -> Estimate:
        """Mean margin with its interval, in points."""
        return mean_interval(self.margins)

    @property
    def points_shares(self) -> tuple[float, ...]:
        """Share of the games that ended with 0, 1, 2, ... control points held."""
        counts = np.bincount(self.points_held)
        return tuple(float(count) / max(self.games, 1) for count in counts)

    @classmethod
    def joined(cls, results: Iterable[CampResult]) -> CampResult:
        """The games of all these results, as of both colours."""
        results = list(results)
        return cls(
            np.concatenate([result.scores for result in results]),
            np.concatenate([result.margins for result in results]),
            np.concatenate([result.points_held for result in results]),
        )

    def summary(self) -> dict[str, Any]:
        """All figures as JSON values."""
        win_rate, margin = self.win_rate, self.mean_margin
        return {
            "games": self.games,
            "wins": self.wins,
            "draws": self.draws,
            "losses": self.losses,
            "win_rate": win_rate.value,
            "win_rate_interval": [win_rate.low, win_rate.high],
            "mean_margin": margin.value,
            "mean_margin_interval": [margin.low, margin.high],
            "points_held": list(self.points_shares),
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class MatchResult:
    """A match: `red` and `blue` are the two camps' views; the figures of the match are red's."""

    red_name: str
    blue_name: str
    scenario: str
    seed: int
    red: CampResult
    blue: CampResult

    @property
    def games(self) -> int:
        """Number of games."""
        return self.red.games

    @property
    def wins(self) -> int:
        """Games that red won."""
        return self.red.wins

    @property
    def draws(self) -> int:
        """Games that nobody won."""
        return self.red.draws

    @property
    def losses(self) -> int:
        """Games that red lost."""
        return self.red.losses

    @property
    def win_rate(self) -> Estimate:
        """Red's win rate with its Wilson interval, in 0..1."""
        return self.red.win_rate

    @property
    def mean_margin(self) -> Estimate:
        """Red's mean margin with its interval, in points."""
        return self.red.mean_margin

    def summary(self) -> dict[str, Any]:
        """All figures as JSON values."""
        return {
            "scenario": self.scenario,
            "seed": self.seed,
            "red": {"player": self.red_name, **self.red.summary()},
            "blue": {"player": self.blue_name, **self.blue.summary()},
        }

    def __str__(self) -> str:
        return (
            f"{self.red_name} (red) against {self.blue_name} (blue), {self.games} games on {self.scenario}: "
            f"{self.wins} won, {self.draws} drawn, {self.losses} lost; "
            f"win rate {self.win_rate.percent()}, mean margin {self.mean_margin}"
        )
