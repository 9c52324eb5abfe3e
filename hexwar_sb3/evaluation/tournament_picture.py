"""A tournament as a picture: who beats whom on each map, and the ratings over all of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hexwar_sb3.evaluation.elo import Ratings
from hexwar_sb3.evaluation.tournament import Meeting, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

COLOURS = "RdBu_r"  # of win rates


def draw_tournament(table: Table, names: list[str], path: Path) -> None:
    """Write heat maps, one a map, and the ratings.

    Args:
        table: of the tournament.
        names: players, in the order of rows and columns.
        path: picture.
    """
    from hexwar_sb3.pictures import new_figure, write_figure

    scenarios = table.scenarios
    side = 2.5 + 0.6 * len(names)
    figure = new_figure(side * (len(scenarios) + 1) + 0.6, side)
    *maps, last = figure.subplots(1, len(scenarios) + 1)
    drawn = [_draw_map(axes, table, names, scenario) for axes, scenario in zip(maps, scenarios, strict=True)]
    bar = figure.colorbar(
        drawn[-1], ax=maps, shrink=0.7, pad=0.01, format=lambda share, _: f"{100 * share:.0f}"
    )
    bar.set_label("red wins, %")
    _draw_ratings(last, table.ratings(), names)
    write_figure(figure, path)


def _draw_map(axes: Axes, table: Table, names: list[str], scenario: str) -> AxesImage:
    """Win rate of red, a row a red player."""
    import matplotlib as mpl

    from hexwar_sb3.pictures import ink_on

    colours = mpl.colormaps[COLOURS]
    rates = np.full((len(names), len(names)), np.nan)
    for i, red in enumerate(names):
        for j, blue in enumerate(names):
            row = table.rows.get(Meeting(red=red, blue=blue, scenario=scenario))
            if row is not None:
                rates[i, j] = row["red"]["win_rate"]
                text, ink = f"{100 * rates[i, j]:.0f}", ink_on(colours, float(rates[i, j]))
                axes.text(j, i, text, color=ink, ha="center", va="center", fontsize="small")
    image = axes.imshow(rates, cmap=colours, vmin=0.0, vmax=1.0, aspect="auto")
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="blue", ylabel="red")
    axes.set_title(f"{Path(scenario).name}: win rate of red, %", fontsize="medium", loc="left")
    axes.spines[:].set_visible(False)
    return image


def _draw_ratings(axes: Axes, ratings: Ratings, names: list[str]) -> None:
    """A point a player, with its interval; the best is on top."""
    from hexwar_sb3.pictures import colour, dress

    order = sorted(names, key=lambda name: ratings.players[name].value)
    for place, name in enumerate(order):
        elo = ratings.players[name]
        axes.hlines(place, elo.low, elo.high, color=colour(0))
        axes.plot(elo.value, place, "o", color=colour(0))
    axes.set_yticks(range(len(order)), order)
    dress(axes, "over all maps, with 95 % intervals", xlabel="Elo")
