from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.experiments.ablation import HEADS, cells, runs, summary
from hexwar_sb3.experiments.ablation_picture import draw
from hexwar_sb3.experiments.runs import Budget, Places, choose

MakeFolder = Callable[..., Path]
RUNS = runs(Budget(games=100), [0, 1])


def test_a_row_has_the_mean_and_the_spread_over_its_seeds(places: Places, make_results: MakeFolder) -> None:
    """Both colours together: red is 0.2 and 20 points above blue; two points in every other game."""
    for run, win_rate, margin in zip(choose(RUNS, ["vdn"]), (0.3, 0.5), (-40.0, 0.0), strict=True):
        make_results(run, win_rate=win_rate, margin=margin)

    (row,) = (row for row in summary(RUNS, places) if row["row"] == "vdn")

    assert row["seeds"] == [0, 1]
    assert row["against"]["MA1"]["win_rate"] == pytest.approx([0.5, 0.4, 0.6])
    assert row["against"]["MA2"]["mean_margin"] == pytest.approx([-10.0, -30.0, 10.0])
    assert row["against"]["MA2"]["points_held"] == pytest.approx([1.0, 1.0, 1.0])


def test_a_row_stands_beside_the_base(places: Places, make_results: MakeFolder) -> None:
    """Margins 100, 120 and 0, 20: variances 200, two degrees of freedom, half the width 4.303 sqrt(200)."""
    for name, margins in (("base", (0.0, 20.0)), ("vdn", (100.0, 120.0))):
        for run, margin in zip(choose(RUNS, [name]), margins, strict=True):
            make_results(run, margin=margin)

    lines = {tuple(line[:2]): line for line in cells(summary(RUNS, places))}

    assert lines["vdn", "MA1"][2:] == [
        *("2", "60.0 [60.0, 60.0]", "+120.0 [+110.0, +130.0]", "1.00 [1.00, 1.00]"),
        "+100.0 [+39.1, +160.9]",
    ]
    assert lines["base", "MA2"][-1] == ""


def test_a_row_without_results_is_missing_and_one_without_base_has_no_difference(
    places: Places, make_results: MakeFolder
) -> None:
    make_results(*choose(RUNS, ["vdn-0"]))

    lines = {line[0]: line for line in cells(summary(RUNS, places))}

    assert lines["iql"] == ["iql", "-", "0", "missing", "", "", ""]
    assert lines["vdn"][-1] == "- [-, -]"
    assert all(len(line) == len(HEADS) for line in lines.values())


def test_the_picture_shows_the_rows_that_are_there(
    places: Places, make_results: MakeFolder, tmp_path: Path
) -> None:
    empty, full = tmp_path / "empty.png", tmp_path / "full.png"
    draw(summary(RUNS, places), RUNS, places, empty)
    for run in choose(RUNS, ["base", "vdn-0", "iql-0"]):
        make_results(run)

    draw(summary(RUNS, places), RUNS, places, full)

    for path in (empty, full):
        assert path.read_bytes().startswith(b"\x89PNG")
    assert full.read_bytes() != empty.read_bytes()
