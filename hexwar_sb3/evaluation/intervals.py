"""Intervals beside every figure: Wilson for shares, normal for means and paired differences."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

CONFIDENCE = 0.95
LEAST_GAMES = 2  # of an interval over games  # two-sided, of every interval that we print


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure with its interval; `low` and `high` are the ends of the interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.2f} [{self.low:.2f}, {self.high:.2f}]"

    def percent(self) -> str:
        """Text of a share: `83.1 % [81.4, 84.7]`."""
        return f"{100 * self.value:.1f} % [{100 * self.low:.1f}, {100 * self.high:.1f}]"


def normal_quantile(confidence: float) -> float:
    """Return z such that a standard normal lies within -z..z with this probability."""
    return NormalDist().inv_cdf((1 + confidence) / 2)


def wilson(successes: float, trials: float, confidence: float = CONFIDENCE) -> Estimate:
    """Share of successes with the Wilson score interval (Wilson 1927).

    Args:
        successes: number of successes in 0..trials; a draw counts one half.
        trials: number of trials, perhaps an effective one; 0 gives the interval 0..1.
        confidence: probability that the interval covers the true share.

    Example:
        >>> wilson(83, 100).percent()
        '83.0 % [74.5, 89.1]'
    """
    if trials == 0:
        return Estimate(0.5, 0.0, 1.0)
    z = normal_quantile(confidence)
    share = successes / trials
    centre = (share + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z * sqrt(share * (1 - share) / trials + (z / (2 * trials)) ** 2) / (1 + z * z / trials)
    return Estimate(share, max(0.0, min(share, centre - half)), min(1.0, max(share, centre + half)))


def mean_interval(values: npt.ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Mean of `values` [game] with its normal interval; of one value the interval is the value."""
    sample = np.asarray(values, dtype=np.float64)
    if sample.size == 0:
        return Estimate(float("nan"), float("nan"), float("nan"))
    mean = float(sample.mean())
    error = float(sample.std(ddof=1)) / sqrt(sample.size) if sample.size > 1 else 0.0
    half = normal_quantile(confidence) * error
    return Estimate(mean, mean - half, mean + half)


def paired_interval(ours: npt.ArrayLike, theirs: npt.ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Mean of `ours - theirs` [game], game by game on the same seeds.

    "Better" means that the interval excludes zero, "no worse" that its lower end is above -3 points.
    """
    return mean_interval(
        np.asarray(ours, dtype=np.float64) - np.asarray(theirs, dtype=np.float64), confidence
    )


def ratio_interval(parts: npt.ArrayLike, wholes: npt.ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Sum of `parts` over sum of `wholes`, with the normal interval over games, within which nothing is independent.

    Args:
        parts: of each game [game].
        wholes: likewise; a game may have 0.
        confidence: probability that the interval covers the true ratio.

    Example:
        >>> ratio_interval([8, 6, 7], [10, 10, 10]).percent()
        '70.0 % [58.7, 81.3]'
    """
    tops, bottoms = (np.asarray(values, dtype=np.float64) for values in (parts, wholes))
    if tops.size < LEAST_GAMES or not bottoms.sum():
        value = float(tops.sum() / bottoms.sum()) if bottoms.sum() else float("nan")
        return Estimate(value, float("nan"), float("nan"))
    ratio = float(tops.sum() / bottoms.sum())
    rest = tops - ratio * bottoms
    error = sqrt(float((rest**2).sum()) * tops.size / (tops.size - 1)) / float(bottoms.sum())
    half = normal_quantile(confidence) * error
    return Estimate(ratio, ratio - half, ratio + half)
