"""What a model's score is made of."""

from __future__ import annotations

import pytest

from hexwar_sb3.evaluation.tournament import Meeting, Table
from hexwar_sb3.league.selection import select, standings


def table_of(rates: dict[tuple[str, str], float]) -> Table:
    """Of matches of 100 games, by red's share of the wins."""
    rows = {}
    for (red, blue), rate in rates.items():
        cells = [
            {"win_rate": share, "games": 100, "mean_margin": 100 * share} for share in (rate, 1.0 - rate)
        ]
        rows[Meeting(red=red, blue=blue, scenario="plain")] = {"red": cells[0], "blue": cells[1]}
    return Table(rows)


RATES = {
    ("a", "x"): 0.75,
    ("b", "x"): 0.5,
    ("a", "MA1"): 0.5,
    ("b", "MA1"): 1.0,
    ("a", "MA2"): 0.25,
    ("b", "MA2"): 0.125,
    ("MA1", "x"): 0.5,
}


def test_what_was_forgotten_of_one_rival_is_not_made_up_with_others() -> None:
    """A is 0.5 behind b against MA1; b is 0.125 behind a against MA2, and that both lose to MA2 decides nothing."""
    one, other = standings(table_of(RATES), "red", rivals=("MA1", "MA2"), worst_share=0.5)
    assert (one["name"], one["win_rate"], one["behind"], one["score"]) == ("b", 0.5, 0.125, 0.6875)
    assert (other["name"], other["win_rate"], other["behind"], other["score"]) == ("a", 0.75, 0.5, 0.625)
    assert one["mean_margin"] == pytest.approx(162.5 / 3)


def test_without_a_share_all_opponents_count_alike() -> None:
    one, other = standings(table_of(RATES), "red", rivals=("MA1", "MA2"))
    assert [(row["name"], row["score"], row["behind"]) for row in (one, other)] == [
        ("b", 1.625 / 3, 0.0),
        ("a", 0.5, 0.0),
    ]


def test_models_of_both_camps_are_ranked_by_both() -> None:
    def row(name: str, rate: float, margin: float = 0.0) -> dict[str, object]:
        return {"name": name, "score": rate, "mean_margin": margin}

    rows = {
        "red": [row("a", 0.9), row("b", 0.6), row("c", 0.5, 3.0)],
        "blue": [row("b", 0.8), row("a", 0.7), row("c", 0.1)],
    }

    assert select(rows, 2, split=True) == {"red": ["a", "b"], "blue": ["b", "a"]}
    assert select(rows, 4, split=False) == {"red": ["a", "b", "c", "a"], "blue": ["a", "b", "c", "a"]}
    level = {"red": [row("x", 0.5, 1.0), row("y", 0.5, 2.0), row("z", 0.5, 2.0)]}
    assert select({**level, "blue": level["red"]}, 3, split=False)["red"] == ["y", "z", "x"]
