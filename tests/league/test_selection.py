"""What a model's score is made of."""

from __future__ import annotations

import pytest

from hexwar_sb3.league.selection import select, weights


@pytest.mark.parametrize(
    ("rates", "are_rivals", "share", "expected"),
    [
        ([0.9, 0.1, 0.8, 0.3], [False, False, True, True], 0.5, [0.25, 0.25, 0.0, 0.5]),
        ([0.9, 0.1, 0.3, 0.8], [False, False, True, True], 0.5, [0.25, 0.25, 0.5, 0.0]),
        ([0.2, 0.7], [True, True], 0.5, [1.0, 0.0]),
        ([0.2, 0.7], [False, False], 0.0, [0.5, 0.5]),
        ([0.2, 0.7], [False, True], 1.0, [0.0, 1.0]),
        ([0.4], [False], 0.5, [1.0]),
    ],
)
def test_of_the_rivals_only_the_worst_result_counts(
    rates: list[float], are_rivals: list[bool], share: float, expected: list[float]
) -> None:
    assert weights(rates, are_rivals, share) == expected


def test_models_of_both_camps_are_ranked_by_both() -> None:
    def row(name: str, rate: float, margin: float = 0.0) -> dict[str, object]:
        return {"name": name, "win_rate": rate, "mean_margin": margin}

    rows = {
        "red": [row("a", 0.9), row("b", 0.6), row("c", 0.5, 3.0)],
        "blue": [row("b", 0.8), row("a", 0.7), row("c", 0.1)],
    }

    assert select(rows, 2, split=True) == {"red": ["a", "b"], "blue": ["b", "a"]}
    assert select(rows, 4, split=False) == {"red": ["a", "b", "c", "a"], "blue": ["a", "b", "c", "a"]}
    level = {"red": [row("x", 0.5, 1.0), row("y", 0.5, 2.0), row("z", 0.5, 2.0)]}
    assert select({**level, "blue": level["red"]}, 3, split=False)["red"] == ["y", "z", "x"]
