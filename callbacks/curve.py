"""The picture of a training run: win rate and mean margin over env steps, with their intervals."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.files import replacing


def draw_curve(history: History, path: Path) -> None:
    """Write the learning curve as a PNG."""
    figure = Figure(figsize=(9, 4), layout="constrained")
    FigureCanvasAgg(figure)
    shares, margins = figure.subplots(1, 2)
    _draw(shares, history.timesteps, [result.win_rate for result in history.results], "win rate")
    _draw(
        margins, history.timesteps, [result.mean_margin for result in history.results], "mean margin, points"
    )
    shares.set_ylim(0, 1)
    margins.axhline(0, color="grey", linewidth=0.8)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=120)


def _draw(axes: Axes, steps: list[int], estimates: list[Estimate], label: str) -> None:
    axes.plot(steps, [estimate.value for estimate in estimates], marker="o", markersize=3)
    axes.fill_between(steps, [e.low for e in estimates], [e.high for e in estimates], alpha=0.25)
    axes.set_xlabel("env steps")
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))  # 250k
    axes.set_ylabel(label)
    axes.grid(alpha=0.3)
