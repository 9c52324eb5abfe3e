from __future__ import annotations

import math

import numpy as np
import pytest

from hexwar_sb3.evaluation.intervals import mean_interval, paired_interval, wilson


def test_wilson_agrees_with_a_published_example() -> None:
    """81 of 263: 0.2553..0.3662 (Newcombe 1998, table I, method 3)."""
    estimate = wilson(81, 263)

    assert estimate.value == pytest.approx(0.3080, abs=5e-5)
    assert (estimate.low, estimate.high) == pytest.approx((0.2553, 0.3662), abs=5e-5)


@pytest.mark.parametrize("trials", [1, 7, 2000])
def test_wilson_stays_in_0_to_1_at_its_ends(trials: int) -> None:
    assert wilson(0, trials).low == 0.0
    assert wilson(trials, trials).high == 1.0
    assert 0.0 < wilson(0, trials).high < 1.0


def test_wilson_without_games_knows_nothing() -> None:
    assert (wilson(0, 0).low, wilson(0, 0).high) == (0.0, 1.0)


@pytest.mark.parametrize("successes", [0, 3, 10])
def test_wilson_is_symmetric_between_wins_and_losses(successes: int) -> None:
    won, lost = wilson(successes, 10), wilson(10 - successes, 10)

    assert (won.low, won.high) == pytest.approx((1 - lost.high, 1 - lost.low))


def test_a_mean_has_the_normal_interval() -> None:
    """Mean 3, variance 2.5, five values: 3 -+ 1.96 sqrt(0.5)."""
    estimate = mean_interval([1, 2, 3, 4, 5])

    assert estimate.value == 3.0
    assert estimate.high - estimate.value == pytest.approx(1.959964 * math.sqrt(0.5), rel=1e-6)


def test_paired_games_take_out_what_the_seeds_share() -> None:
    """The same luck in both samples leaves a difference without spread."""
    luck = np.random.default_rng(0).normal(size=100)

    difference = paired_interval(luck + 0.5, luck)

    assert (difference.low, difference.high) == pytest.approx((0.5, 0.5))


def test_an_estimate_reads_as_a_figure_with_its_interval() -> None:
    assert str(wilson(8, 10)) == "0.80 [0.49, 0.94]"
    assert wilson(8, 10).percent() == "80.0 % [49.0, 94.3]"
