"""A tournament as a picture: who beats whom on each map, and the ratings over all of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hexwar_sb3.evaluation.elo import Ratings
from hexwar_sb3.evaluation.tournament import Meeting, Table
from hexwar_sb3.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DARK = 0.12  # win rate from which on, and below, a field is too dark for black figures


def draw_tournament(table: Table, names: list[str], path: Path) -> None:
    """Write heat maps, one a map, and the ratings.

    Args:
        table: of the tournament.
        names: players, in the order of rows and columns.
        path: picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scenarios = table.scenarios
    side = 2.5 + 0.6 * len(names)
    figure = Figure(figsize=(side * (len(scenarios) + 1), side), layout="constrained")
    FigureCanvasAgg(figure)
    *maps, last = figure.subplots(1, len(scenarios) + 1)
    for axes, scenario in zip(maps, scenarios, strict=True):
        _draw_map(axes, table, names, scenario)
    _draw_ratings(last, table.ratings(), names)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100)


def _draw_map(axes: Axes, table: Table, names: list[str], scenario: str) -> None:
    """Win rate of red, a row a red player."""
    rates = np.full((len(names), len(names)), np.nan)
    for i, red in enumerate(names):
        for j, blue in enumerate(names):
            row = table.rows.get(Meeting(red=red, blue=blue, scenario=scenario))
            if row is not None:
                rates[i, j] = row["red"]["win_rate"]
                text = f"{100 * rates[i, j]:.0f}"
                ink = "black" if DARK < rates[i, j] < 1.0 - DARK else "white"
                axes.text(j, i, text, color=ink, ha="center", va="center", fontsize="small")
    axes.imshow(rates, cmap="RdBu_r", vmin=0.0, vmax=1.0, alpha=0.75)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set(title=f"{Path(scenario).name}: win rate of red, %", xlabel="blue", ylabel="red")


def _draw_ratings(axes: Axes, ratings: Ratings, names: list[str]) -> None:
    """A point a player, with its interval; the best is on top."""
    order = sorted(names, key=lambda name: ratings.players[name].value)
    for place, name in enumerate(order):
        elo = ratings.players[name]
        axes.hlines(place, elo.low, elo.high, color="C0")
        axes.plot(elo.value, place, "o", color="C0")
    axes.set_yticks(range(len(order)), order)
    axes.set(title="over all maps", xlabel="Elo")
    axes.grid(alpha=0.3)
