"""What a model's score is made of."""

from __future__ import annotations

import pytest

from hexwar_sb3.league.selection import weights


@pytest.mark.parametrize(
    ("rates", "are_bots", "share", "expected"),
    [
        ([0.9, 0.1, 0.8, 0.3], [False, False, True, True], 0.5, [0.25, 0.25, 0.0, 0.5]),
        ([0.9, 0.1, 0.3, 0.8], [False, False, True, True], 0.5, [0.25, 0.25, 0.5, 0.0]),
        ([0.2, 0.7], [True, True], 0.5, [1.0, 0.0]),
        ([0.2, 0.7], [False, False], 0.0, [0.5, 0.5]),
        ([0.2, 0.7], [False, True], 1.0, [0.0, 1.0]),
        ([0.4], [False], 0.5, [1.0]),
    ],
)
def test_of_the_bots_only_the_worst_result_counts(
    rates: list[float], are_bots: list[bool], share: float, expected: list[float]
) -> None:
    assert weights(rates, are_bots, share) == expected
