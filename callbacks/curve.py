"""The picture of a training run: win rate and mean margin over env steps, with their intervals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.pictures import FAINT, INK, colour, draw_band, dress, new_figure, write_figure

_LOWER_LEARNED = 1.02  # times the game ticks that the env steps alone took: the lower level learned, too


def draw_curve(history: History, path: Path, *, title: str = "", decision_ticks: int | None = None) -> None:
    """Write the learning curve as a picture.

    Args:
        history: of the run.
        path: picture.
        title: what was trained, where, against whom.
        decision_ticks: of an env step; phases of the lower level are marked by it. None: they are not known.
    """
    figure = new_figure(9.5, 4.2)
    shares, margins = figure.subplots(1, 2)
    wins, points = (
        [getattr(result, name) for result in history.results] for name in ("win_rate", "mean_margin")
    )
    _draw(shares, history.timesteps, wins, colour(0))
    _draw(margins, history.timesteps, points, colour(1))
    dress(shares, "win rate", xlabel="env steps", ylim=(0, 1))
    dress(margins, "mean margin, points", xlabel="env steps")
    margins.axhline(0, color=INK, linewidth=0.6)
    phases = list(lower_phases(history, decision_ticks)) if decision_ticks else []
    for axes in (shares, margins):
        for start, end in phases:
            axes.axvspan(start, end, color=FAINT, alpha=0.15, linewidth=0)
    games = history.results[0].games if history.results else 0
    told = [
        f"band: 95 % interval of {games:,} games an evaluation",
        *(["grey: the lower level learned before the next one"] if phases else []),
    ]
    figure.suptitle("\n".join(filter(None, (title, "; ".join(told)))), fontsize="medium", color=INK)
    write_figure(figure, path)


def lower_phases(history: History, decision_ticks: int) -> Iterator[tuple[int, int]]:
    """Env steps of the evaluations between which other levels used game time, too."""
    points = list(zip(history.timesteps, history.game_ticks, strict=True))
    for (start, ticks), (end, later) in pairwise(points):
        if later - ticks > _LOWER_LEARNED * (end - start) * decision_ticks:
            yield start, end


def _draw(axes: Axes, steps: Sequence[int], estimates: Sequence[Estimate], line: str) -> None:
    values = [estimate.value for estimate in estimates]
    draw_band(axes, steps, values, [e.low for e in estimates], [e.high for e in estimates], color=line)
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))  # 250k
