"""Table I in words: every cell as measured, with its interval, beside the paper's figure; and what misses its bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.evaluation.intervals import Estimate, paired_interval
from hexwar_sb3.evaluation.panel import BOTS, CONSTANT_PLANS
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.tournament import Meeting, Table
from hexwar_sb3.experiments.table1 import COLUMNS, FURTHER, ROWS, Table1
from hexwar_sb3.files import replacing, write_json
from hexwar_sb3.league.cai import DISTILLED
from hexwar_sb3.league.cost import Cost
from hexwar_sb3.league.member import CAMPS

PAPER = {  # percent as red and as blue; Tab. I
    ("HRL0", "MA1"): (94, 93),
    ("HRL0", "MA2"): (89, 87),
    ("HRL0", "HRL0"): (53, 47),
    ("HRL0", "HRL1"): (20, 23),
    ("HRL1", "MA1"): (97, 96),
    ("HRL1", "MA2"): (91, 94),
    ("HRL1", "HRL0"): (77, 80),
    ("HRL1", "HRL1"): (51, 49),
    ("HRL2", "MA1"): (90, 93),
    ("HRL2", "MA2"): (94, 95),
    ("HRL2", "HRL0"): (78, 78),
    ("HRL2", "HRL1"): (46, 48),
    ("CAI", "MA1"): (100, 100),
    ("CAI", "MA2"): (99, 95),
    ("CAI", "HRL0"): (88, 85),
    ("CAI", "HRL1"): (69, 64),
}
PERFECT = 99  # the bar where the paper has 100
SCORES = {"W": 1.0, "D": 0.5, "L": 0.0}
NO_WORSE = -3.0  # points: lower end of the paired interval (learning.md, section 7)
Row = dict[str, Any]
LayOut = Callable[[Sequence[str], Sequence[Sequence[str]]], str]  # heads and rows, as text


def rows(table: Table, scenario: str) -> list[Row]:
    """One JSON object a cell of Tab. I: row, column, camp of the row's player, figures, the paper's figure and the bar."""
    found = []
    for name in (*ROWS, *FURTHER, *CONSTANT_PLANS):
        for column in COLUMNS:
            for k, camp in enumerate(CAMPS):
                cell = table.rows[meeting(name, column, camp, scenario)][camp]
                paper = PAPER.get((name, column))
                found.append(
                    {
                        "row": name,
                        "column": column,
                        "camp": camp,
                        **{key: value for key, value in cell.items() if key != "player"},
                        "paper": None if paper is None else paper[k] / 100,
                        "bar": bar(name, column, k),
                    }
                )
    return found


def bar(row: str, column: str, k: int) -> float | None:
    """Least win rate of a cell; None where the paper's cell is only reported."""
    judged = column in BOTS or (column == "HRL0" and row != "HRL0") or (row, column) == ("CAI", "HRL1")
    if (row, column) not in PAPER or not judged:
        return None
    return min(PAPER[row, column][k], PERFECT) / 100


def meeting(row: str, column: str, camp: str, scenario: str) -> Meeting:
    """The match in which the row's player has this camp."""
    red, blue = (row, column) if camp == "red" else (column, row)
    return Meeting(red=red, blue=blue, scenario=scenario)


def missed(cells: list[Row]) -> Iterator[str]:
    """Say which cells are below their bars."""
    for cell in cells:
        if cell["bar"] is not None and cell["win_rate"] < cell["bar"]:
            low, high = cell["win_rate_interval"]
            yield (
                f"{cell['row']} against {cell['column']} as {cell['camp']}: {100 * cell['win_rate']:.1f} %"
                f" [{100 * low:.1f}, {100 * high:.1f}], bar {100 * cell['bar']:.0f}"
            )


def scores(table: Table, name: str, columns: tuple[str, ...], scenario: str) -> NDArray[np.float64]:
    """Results of a player game by game, against these columns in both colours; the same seeds for every player."""
    parts = []
    for column in columns:
        for camp in CAMPS:
            letters = table.rows[meeting(name, column, camp, scenario)]["red_games"]
            red = np.array([SCORES[letter] for letter in letters])
            parts.append(red if camp == "red" else 1.0 - red)
    return np.concatenate(parts)


def no_worse(table: Table, scenario: str) -> list[Row]:
    """Paired differences in points of win rate: against the bots, and of CAI and its teachers against all columns."""
    comparisons: list[tuple[str, str, tuple[str, ...]]] = [
        (name, "HRL0", (bot,)) for name in ("HRL1", "HRL2", "CAI") for bot in BOTS
    ]
    comparisons += [(name, "HRL1", COLUMNS) for name in ("CAI", DISTILLED)]
    comparisons += [(name, "HRL2", COLUMNS) for name in ("CAI", DISTILLED)]
    found = []
    for name, other, columns in comparisons:
        ours, theirs = (scores(table, one, columns, scenario) for one in (name, other))
        gain: Estimate = paired_interval(100 * ours, 100 * theirs)
        against = columns[0] if len(columns) == 1 else "all columns"
        found.append(
            {
                "player": name,
                "minus": other,
                "against": against,
                "points": gain.value,
                "interval": [gain.low, gain.high],
                "no_worse": gain.low > NO_WORSE,
            }
        )
    return found


def in_words(cells: list[Row], compared: list[Row], costs: Cost, lay_out: LayOut) -> str:
    """Win rates as in the paper's table, margins and points held below, and what is missed."""
    by_place = {(cell["row"], cell["column"], cell["camp"]): cell for cell in cells}
    names = list(dict.fromkeys(cell["row"] for cell in cells))

    def grid(show: Any) -> str:
        lines = [
            [name, *(" / ".join(show(by_place[name, column, camp]) for camp in CAMPS) for column in COLUMNS)]
            for name in names
        ]
        return lay_out(("", *COLUMNS), lines)

    paper = [
        [
            name,
            *(
                "{} / {}".format(*PAPER[name, column]) if (name, column) in PAPER else ""
                for column in COLUMNS
            ),
        ]
        for name in ROWS
    ]
    gains = [
        [
            one["player"],
            one["minus"],
            one["against"],
            f"{one['points']:+.1f} [{one['interval'][0]:+.1f}, {one['interval'][1]:+.1f}]",
        ]
        for one in compared
    ]
    below = list(missed(cells)) or ["none"]
    whole = {key: sum(cost[key] for cost in costs.values()) for key in ("wall_s", "core_s")}
    spent = [
        [
            stage,
            f"{cost['wall_s'] / 60:.1f}",
            f"{cost['core_s'] / 60:.1f}",
            f"{100 * cost['core_s'] / max(whole['core_s'], 1.0):.0f} %",
        ]
        for stage, cost in {**costs, "all": whole}.items()
    ]
    parts = [
        "Win rate of the row's player, %, as red / as blue; intervals are in table.json.",
        grid(lambda cell: f"{100 * cell['win_rate']:.1f}"),
        "The paper's figures:\n" + lay_out(("", *COLUMNS), paper),
        "Mean margin, points:\n" + grid(lambda cell: f"{cell['mean_margin']:+.0f}"),
        "Control points held at the end, mean:\n"
        + grid(lambda cell: f"{sum(n * share for n, share in enumerate(cell['points_held'])):.2f}"),
        "Paired, points of win rate on the same seeds:\n"
        + lay_out(("player", "minus", "against", "difference"), gains),
        "Cells below their bar:\n" + "\n".join(below),
        "Time, each job counted as a core:\n" + lay_out(("stage", "wall min", "core min", "share"), spent),
    ]
    return "\n\n".join(parts)


def write(table: Table, pipeline: Table1, lay_out: LayOut) -> tuple[Row, str]:
    """Write table.txt, and table.json; what stands in them."""
    scenario, folder = pipeline.settings.scenario, pipeline.kept
    cells, compared = rows(table, scenario), no_worse(table, scenario)
    costs = pipeline.costs()
    text = in_words(cells, compared, costs, lay_out)
    figures = {
        "command": "hexwar experiments table1",
        "settings": asdict(pipeline.settings),
        "CAI": {"lessons": asdict(pipeline.lessons), "games": pipeline.cai_games},
        "games": pipeline.games,
        **provenance(scenario),
        "cells": cells,
        "paired": compared,
        "missed": list(missed(cells)),
        "costs": costs,
    }
    write_json(folder / "table.json", figures)
    with replacing(folder / "table.txt") as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
    return figures, text
