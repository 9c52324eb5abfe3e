"""How commands print: tables for people, one JSON object for programs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from hexwar_sb3.evaluation.panel import Panel
from hexwar_sb3.evaluation.results import CampResult

HEADS = ("player", "opponent", "camp", "games", "won/drawn/lost", "win rate, %", "mean margin", "points held")


def print_json(values: Mapping[str, object] | Sequence[object]) -> None:
    """Print one JSON value."""
    print(json.dumps(values, indent=2, default=str))


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lay out rows of text under their heads, columns padded to their widest cell."""
    widths = [max(len(row[i]) for row in [heads, *rows]) for i in range(len(heads))]
    lines = [heads, ["-" * width for width in widths], *rows]
    return "\n".join("  ".join(f"{cell:<{w}}" for cell, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def panel_table(panels: Sequence[Panel]) -> str:
    """One row a player, opponent and camp."""
    rows = [
        [panel.player, opponent, camp, *result_cells(result)]
        for panel in panels
        for (opponent, camp), result in panel.cells.items()
    ]
    return table(HEADS, rows)


def result_cells(result: CampResult) -> list[str]:
    """Cells of a result: games, wins, win rate and margin with intervals, points held."""
    rate, margin = result.win_rate, result.mean_margin
    return [
        str(result.games),
        f"{result.wins}/{result.draws}/{result.losses}",
        f"{100 * rate.value:.1f} [{100 * rate.low:.1f}, {100 * rate.high:.1f}]",
        f"{margin.value:+.1f} [{margin.low:+.1f}, {margin.high:+.1f}]",
        points_text(result),
    ]


def points_text(result: CampResult) -> str:
    """Shares of the games that ended with 0, 1, 2, ... points held: `0: 5%, 1: 15%, 2: 80%`."""
    return ", ".join(f"{n}: {share:.0%}" for n, share in enumerate(result.points_shares))
