"""Elo ratings of players who met each other: one number a player, with its interval (Bradley and Terry 1952)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, log, sqrt

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_number, check_whole
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.intervals import CONFIDENCE, Estimate, normal_quantile

MEAN = 1500.0  # of all ratings
PER_LOGIT = 400.0 / log(10.0)  # ten times the odds are 400 points
PRIOR_GAMES = 2.0  # a won and a lost game of each player against the mean: keeps the unbeaten finite
STEPS, ENOUGH = 100, 1e-9  # of Newton's method, or halvings of an interval; change of a logit
MOST_ELO = 1e4  # either way, of a player whose rating is known


@dataclass(frozen=True, kw_only=True)
class Pairing:
    """How many games two players had, and how they ended for red."""

    red: str
    blue: str
    games: int
    score: float  # games won by red, and half of the drawn ones
    scenario: str = ""


@dataclass(frozen=True)
class Ratings:
    """Ratings by player, and what red's seat is worth by scenario; all in Elo points."""

    players: dict[str, Estimate]
    red_seat: dict[str, Estimate]


def elo_ratings(pairings: Sequence[Pairing]) -> Ratings:
    """Fit P(red wins) = sigma((Elo of red - Elo of blue + red's seat) * ln 10 / 400) to the games.

    Draws count as half a win. A rating is one number: where players beat each other in a circle, read the table.
    Intervals are those of the fit, at 95 %.

    Args:
        pairings: of all scenarios; every player is rated by all of them.
    """
    names = sorted({name for pairing in pairings for name in (pairing.red, pairing.blue)})
    maps = sorted({pairing.scenario for pairing in pairings})
    design = np.zeros((len(pairings), len(names) + len(maps)))
    for row, pairing in zip(design, pairings, strict=True):
        row[names.index(pairing.red)] += 1.0
        row[names.index(pairing.blue)] -= 1.0
        row[len(names) + maps.index(pairing.scenario)] = 1.0
    games = np.array([pairing.games for pairing in pairings], np.float64)
    score = np.array([pairing.score for pairing in pairings], np.float64)
    logits, spread = _fit(design, games, score)
    centre = np.eye(len(logits))  # ratings are differences from their mean
    centre[: len(names), : len(names)] -= 1 / len(names)
    half = normal_quantile(CONFIDENCE) * PER_LOGIT * np.sqrt(np.diag(centre @ spread @ centre.T))
    logits = centre @ logits
    pairs = zip((logits * PER_LOGIT).tolist(), half.tolist(), strict=True)
    shown = [Estimate(elo, elo - width, elo + width) for elo, width in pairs]
    players = {
        name: Estimate(MEAN + one.value, MEAN + one.low, MEAN + one.high)
        for name, one in zip(names, shown, strict=False)
    }
    return Ratings(players, dict(zip(maps, shown[len(names) :], strict=True)))


@dataclass(frozen=True, kw_only=True)
class Against:
    """How a player did against one whose rating is known.

    Raises:
        ConfigError: a value is out of its range.
    """

    elo: float  # of the other one, in points; what the seats are worth may be added to it
    games: int = 1
    score: float = 0.0  # games won, and half of the drawn ones

    def __post_init__(self) -> None:
        check_whole("games", self.games, least=1)
        if not abs(check_number("elo", self.elo)) <= MOST_ELO:
            raise ConfigError(f"elo must be a number of at most {MOST_ELO:.0f} either way, got {self.elo!r}")
        score = check_number("score", self.score)
        if not (isfinite(score) and 0.0 <= score <= self.games):
            raise ConfigError(f"score must be in 0..{self.games}, the games, got {self.score!r}")


def rate_player(results: Sequence[Against]) -> Estimate:
    """Rate one player by its results against players whose ratings are known.

    The rating of greatest likelihood under the prior of `elo_ratings`, PRIOR_GAMES games at a score of one half against
    the mean: without a game it is the mean, and who always won has a finite one. The interval is that of the fit, at
    95 %; what is uncertain of the others' ratings is not in it.

    Args:
        results: in any order; one opponent may come several times.

    Example:
        >>> print(rate_player([Against(elo=1700, games=20, score=10), Against(elo=1500, games=10, score=8)]))
        1697.18 [1570.36, 1823.99]
    """
    met: list[tuple[float, float, float]] = [
        ((one.elo - MEAN) / PER_LOGIT, one.games, one.score) for one in results
    ]
    met.append((0.0, PRIOR_GAMES, PRIOR_GAMES / 2))
    others, games, scores = np.array(met, np.float64).T

    def slope(own: float) -> float:
        return float((scores - games * _sigmoid(own - others)).sum())

    logit = _root(slope, float(others.min()), float(others.max()))
    expected = _sigmoid(logit - others)
    half = normal_quantile(CONFIDENCE) * PER_LOGIT / sqrt(float((games * expected * (1 - expected)).sum()))
    elo = MEAN + logit * PER_LOGIT
    return Estimate(elo, elo - half, elo + half)


def _root(falling: Callable[[float], float], low: float, high: float) -> float:
    """Where a falling function is zero, by halving; first the interval is widened until it is in there."""
    while falling(low) < 0.0:
        low -= 1.0
    while falling(high) > 0.0:
        high += 1.0
    for _ in range(STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if falling(middle) > 0.0 else (low, middle)
    return (low + high) / 2


def _fit(
    design: NDArray[np.float64], games: NDArray[np.float64], score: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Logits of greatest likelihood under the prior [parameter], and their covariance."""
    logits = np.zeros(design.shape[1])
    for _ in range(STEPS):
        expected, own = _sigmoid(design @ logits), _sigmoid(logits)
        slope = design.T @ (score - games * expected) + PRIOR_GAMES * (0.5 - own)
        curvature = (design.T * (games * expected * (1 - expected))) @ design
        curvature += np.diag(PRIOR_GAMES * own * (1 - own))
        change = np.linalg.solve(curvature, slope)
        logits += change / max(1.0, float(np.abs(change).max()))  # at most one logit a step
        if np.abs(change).max() < ENOUGH:
            break
    return logits, np.asarray(np.linalg.inv(curvature), np.float64)


def _sigmoid(logits: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(1.0 / (1.0 + np.exp(-logits)))
