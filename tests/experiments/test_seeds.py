"""What luck does to a training, counted by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.cli import parse
from hexwar_sb3.experiments.runs import Budget, Places, choose
from hexwar_sb3.experiments.seeds import ALL, CANDIDATES, HEADS, cells, runs, summary

MakeFolder = Callable[..., Path]
RUNS = runs(Budget(games=100), range(4))


def test_candidates_have_all_seeds_on_plain_and_the_default_three_on_other_maps() -> None:
    names = {run.name for run in RUNS}

    assert {f"{name}-{seed}" for name in ("default", *CANDIDATES, "hrl-plain") for seed in range(4)} <= names
    assert {f"{scenario}-{seed}" for scenario in ("hills", "paddy") for seed in range(3)} <= names
    assert len(names) == 4 * len(CANDIDATES) + 8 + 6
    assert all(parse(run.arguments).games == 100 for run in RUNS)


def test_mean_worst_and_deviation_over_seeds(places: Places, make_results: MakeFolder) -> None:
    """Red wins 0.2 more than blue, who wins what is given; against the others half of that."""
    for run, rate in zip(choose(RUNS, ["default"]), (0.4, 0.5, 0.6, 0.7), strict=True):
        make_results(run, win_rate=rate, margin=100 * rate)

    rows = {(row["against"], row["camp"]): row for row in summary(RUNS, places)}
    assert rows[ALL, "both"]["win_rates"] == pytest.approx([0.5, 0.6, 0.7, 0.8])
    assert (rows[ALL, "both"]["mean"], rows[ALL, "both"]["worst"]) == pytest.approx((0.65, 0.5))
    assert rows[ALL, "both"]["sd"] == pytest.approx(0.1291, abs=1e-4)
    assert rows["MA2", "red"]["worst"] == pytest.approx(0.6)
    assert rows["drawn-unseen", "blue"]["mean"] == pytest.approx(0.275)
    assert rows["drawn-unseen", "blue"]["mean_margin"] == pytest.approx(55.0)
    assert rows["nearest", "red"]["seeds"] == [0, 1, 2, 3]


def test_the_table_shows_what_is_there(places: Places, make_results: MakeFolder) -> None:
    assert list(cells(summary(RUNS, places))) == []
    make_results(*choose(RUNS, ["paddy-0"]))
    lines = list(cells(summary(RUNS, places)))

    assert lines[0] == ["paddy", "1", ALL, "both", "60.0", "60.0", "-", "", ""]
    assert ["paddy", "1", "MA1", "red", "70.0", "70.0", "-", "+20", "1.00"] in lines
    assert all(len(line) == len(HEADS) for line in lines)
