"""The ablation as a picture: the margin of every row, and how some of them got there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.ablation import BASE
from hexwar_sb3.experiments.curve import ALL, band
from hexwar_sb3.experiments.runs import Places, Run
from hexwar_sb3.files import replacing

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
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    there = [row for row in rows if row["against"]]
    figure = Figure(figsize=(14, max(4.0, 0.32 * len(there) + 1.0)), layout="constrained")
    FigureCanvasAgg(figure)
    margins, curves = figure.subplots(1, 2)
    _draw_margins(margins, there)
    for k, name in enumerate(name for name in CURVES if name in {row["row"] for row in there}):
        kept = [places.kept(run) for run in all_runs if run.row == name and places.is_kept(run)]
        mean = band([one.curve(ALL) for one in kept], "mean_margin")
        curves.plot(mean.ticks / MILLION, mean.mean, color=f"C{k}", marker="o", markersize=3, label=name)
        curves.fill_between(mean.ticks / MILLION, mean.low, mean.high, color=f"C{k}", alpha=0.15, linewidth=0)
    curves.set(xlabel="game time, million ticks", ylabel="mean margin, points", title="learning curves")
    for axes in (margins, curves):
        axes.grid(alpha=0.3)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100)


def _draw_margins(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """A point a row and opponent, the mean over seeds; the line reaches from the lowest to the highest seed."""
    for k, opponent in enumerate(BOTS):
        margins = [row["against"][opponent]["mean_margin"] for row in rows]
        places = [i + 0.3 * (k - 0.5) for i in range(len(rows))]
        axes.hlines(places, [m[1] for m in margins], [m[2] for m in margins], color=f"C{k}", linewidth=1.5)
        axes.plot([m[0] for m in margins], places, "o", color=f"C{k}", label=f"against {opponent}")
        for row, margin in zip(rows, margins, strict=True):
            if row["row"] == BASE:  # to compare with
                axes.axvline(margin[0], color=f"C{k}", linewidth=0.8, linestyle=":")
    labels = [f"{row['row']} ({len(row['seeds'])})" for row in rows]
    axes.set_yticks(range(len(rows)), labels)
    axes.invert_yaxis()
    axes.set(xlabel="mean margin, points", title="rows of the ablation (seeds)")
