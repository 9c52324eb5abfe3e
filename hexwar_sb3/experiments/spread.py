"""Figures over seeds: few values, so Student's t in place of the normal distribution."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt
from statistics import fmean, variance

from hexwar_sb3.evaluation.intervals import Estimate

T_95 = (
    *(12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228),
    *(2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086),
)
"""Two-sided 95 % quantiles of Student's t with 1, 2, ... degrees of freedom; the last one stands for more."""


def spread(values: Sequence[float]) -> Estimate:
    """Mean over seeds, with the lowest and the highest seed as its ends."""
    return Estimate(fmean(values), min(values), max(values)) if values else Estimate(nan, nan, nan)


def seed_difference(ours: Sequence[float], theirs: Sequence[float]) -> Estimate:
    """Difference of the means of two rows of seeds, with the two-sample t interval of equal variances.

    Not paired: two trainings with the same seed share no more than two with different ones. Fewer than two
    seeds on either side have no interval: its ends are not numbers.
    """
    if not ours or not theirs:
        return Estimate(nan, nan, nan)
    difference = fmean(ours) - fmean(theirs)
    if min(len(ours), len(theirs)) < 2:
        return Estimate(difference, nan, nan)
    free = len(ours) + len(theirs) - 2
    pooled = ((len(ours) - 1) * variance(ours) + (len(theirs) - 1) * variance(theirs)) / free
    half = T_95[min(free, len(T_95)) - 1] * sqrt(pooled * (1 / len(ours) + 1 / len(theirs)))
    return Estimate(difference, difference - half, difference + half)
