from __future__ import annotations

from math import isnan, sqrt

import pytest

from hexwar_sb3.experiments.spread import seed_difference, spread


def test_a_spread_reaches_from_the_lowest_to_the_highest_seed() -> None:
    found = spread([3.0, 1.0, 5.0])

    assert (found.value, found.low, found.high) == (3.0, 1.0, 5.0)


def test_the_difference_of_two_rows_has_the_two_sample_t_interval() -> None:
    """Variances 1 and 1, four degrees of freedom: half the width is 2.776 sqrt(2 / 3)."""
    found = seed_difference([11.0, 12.0, 13.0], [1.0, 2.0, 3.0])

    half = 2.776 * sqrt(2 / 3)
    assert (found.value, found.low, found.high) == pytest.approx((10.0, 10.0 - half, 10.0 + half))


@pytest.mark.parametrize(("ours", "theirs"), [([4.0], [1.0, 2.0]), ([4.0, 5.0], [3.0])])
def test_one_seed_has_no_interval(ours: list[float], theirs: list[float]) -> None:
    found = seed_difference(ours, theirs)

    assert found.value in {2.5, 1.5}
    assert isnan(found.low)
    assert isnan(found.high)
