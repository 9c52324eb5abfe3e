"""The ablation as a picture: the margin of every row, and how some of them got there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.ablation import BASE, SAYS
from hexwar_sb3.experiments.curve import ALL, band
from hexwar_sb3.experiments.runs import Places, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURVES = (BASE, "vdn", "iql", "maskable-ppo", "flat-dqn", "paper-preset")
MILLION = 1e6


def draw(rows: Sequence[Mapping[str, Any]], all_runs: Sequence[Run], places: Places, path: Path) -> None:
    """Draw the rows that are there.

    Args:
        rows: what `ablation.summary` gives.
        all_runs: of the table.
        places: of their results.
        path: picture.
    """
    from hexwar_sb3.pictures import colour, draw_band, dress, new_figure, write_figure

    there = sorted((row for row in rows if row["against"]), key=_mean_margin, reverse=True)
    figure = new_figure(15, max(4.0, 0.32 * len(there) + 1.0))
    margins, curves = figure.subplots(1, 2)
    _draw_margins(margins, there)
    for k, name in enumerate(name for name in CURVES if name in {row["row"] for row in there}):
        kept = [places.kept(run) for run in all_runs if run.row == name and places.is_kept(run)]
        mean = band([one.curve(ALL) for one in kept], "mean_margin")
        ticks, label = mean.ticks / MILLION, SAYS[name].split(",")[0].split(":")[0]
        draw_band(curves, ticks, mean.mean, mean.low, mean.high, color=colour(k), label=label)
    words = {"xlabel": "game time, million ticks", "ylabel": "mean margin, points"}
    dress(curves, "learning curves; band: lowest to highest seed", **words)
    for axes in (margins, curves):
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")
    write_figure(figure, path)


def _mean_margin(row: Mapping[str, Any]) -> float:
    return fmean(row["against"][opponent]["mean_margin"][0] for opponent in BOTS)


def _draw_margins(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """A point a row and opponent, the mean over seeds; the line reaches from the lowest to the highest seed."""
    from hexwar_sb3.pictures import colour, dress

    for k, opponent in enumerate(BOTS):
        margins = [row["against"][opponent]["mean_margin"] for row in rows]
        places = [i + 0.3 * (k - 0.5) for i in range(len(rows))]
        axes.hlines(places, [m[1] for m in margins], [m[2] for m in margins], color=colour(k), linewidth=1.5)
        axes.plot([m[0] for m in margins], places, "o", color=colour(k), label=f"against {opponent}")
        for row, margin in zip(rows, margins, strict=True):
            if row["row"] == BASE:  # to compare with
                axes.axvline(margin[0], color=colour(k), linewidth=0.8, linestyle=":")
    axes.set_yticks(range(len(rows)), [f"{_words(row)} ({len(row['seeds'])})" for row in rows])
    axes.invert_yaxis()
    dress(axes, "margins, best first (seeds); line: lowest to highest seed", xlabel="mean margin, points")


def _words(row: Mapping[str, Any]) -> str:
    """What a row is, in a line."""
    if row["row"] == BASE:
        return "the defaults, over the heuristic"
    return str(row["says"]).split(",")[0]
