"""Elo ratings of players who met each other: one number a player, with its interval (Bradley and Terry 1952)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.evaluation.intervals import CONFIDENCE, Estimate, normal_quantile

MEAN = 1500.0  # of all ratings
PER_LOGIT = 400.0 / log(10.0)  # ten times the odds are 400 points
PRIOR_GAMES = 2.0  # a won and a lost game of each player against the mean: keeps the unbeaten finite
STEPS, ENOUGH = 100, 1e-9  # of Newton's method; change of a logit


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
