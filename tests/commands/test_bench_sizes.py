"""What larger wars cost: what is measured is what was played."""

from __future__ import annotations

import pytest

from hexwar_sb3.commands import bench_sizes
from hexwar_sb3.commands.bench_sizes import HEADS, exponents, size_figures, war
from hexwar_sb3.engine.world import load_world


def test_a_power_is_found_where_there_is_one() -> None:
    """Times that grow with the pieces and with the square of the cells."""
    rows = [
        {"pieces": pieces, "cells": cells, "random_ms": pieces * cells**2, "bots_ms": 3.0}
        for pieces, cells in ((7, 1e3), (7, 5e3), (7, 2e4), (15, 5e3), (60, 1e3), (60, 5e3), (60, 2e4))
    ]
    found = exponents(rows)
    assert found["random players with pieces"] == pytest.approx([1.0, 1.0])
    assert found["random players with cells, 7 a side"] == pytest.approx([2.0, 2.0])
    assert found["MA1 against MA2 with cells, 60 a side"] == [0.0, 0.0]


def test_every_row_says_what_it_is_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_sizes, "PIECES", (3, 5))
    monkeypatch.setattr(bench_sizes, "MAPS", ((20, 11), (30, 20)))
    monkeypatch.setattr(bench_sizes, "PIECE_GAMES", 1)
    rows = size_figures(1)

    assert [(row["pieces"], row["cells"]) for row in rows] == [(3, 215), (3, 590), (5, 215), (5, 590)]
    assert all(row.keys() == HEADS.keys() for row in rows)
    assert all(row[name] > 0 for row in rows for name in HEADS)
    assert rows[0]["table_mb"] < rows[1]["table_mb"]
    assert rows[0]["game_kb"] == rows[1]["game_kb"] < rows[2]["game_kb"]


def test_wars_of_any_size_are_fought_by_whole_camps() -> None:
    assert load_world(war(60, (245, 245))).n_pieces == 120
