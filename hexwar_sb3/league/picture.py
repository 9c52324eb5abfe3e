"""A league as a picture: how its best models do against those before it, and who comes from whom."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.files import replacing
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import CAMPS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {"red": "C3", "blue": "C0"}
Progress = Mapping[str, Mapping[int, Estimate]]  # opponent -> iteration -> win rate of the best model


def draw_league(league: League, progress: Progress, path: Path) -> None:
    """Write the picture.

    Args:
        league: as far as it is.
        progress: win rates of the best models of both colours together, by opponent and iteration.
        path: picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    done = [k for k in range(league.settings.iterations + 1) if league.is_done(k)]
    figure = Figure(figsize=(14, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    left, *families = figure.subplots(1, 3)
    _draw_progress(left, progress)
    for axes, camp in zip(families, CAMPS, strict=True):
        _draw_family(axes, league, camp, done)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100)


def _draw_progress(axes: Axes, progress: Progress) -> None:
    for k, (opponent, rates) in enumerate(progress.items()):
        iterations = sorted(rates)
        shown = [rates[i] for i in iterations]
        axes.plot(
            iterations,
            [rate.value for rate in shown],
            color=f"C{k}",
            marker="o",
            markersize=3,
            label=opponent,
        )
        axes.fill_between(
            iterations,
            [rate.low for rate in shown],
            [rate.high for rate in shown],
            color=f"C{k}",
            alpha=0.2,
            linewidth=0,
        )
    axes.set(title="the best model of each iteration", xlabel="iteration", ylabel="win rate", ylim=(0, 1.02))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(alpha=0.3)
    if progress:
        axes.legend(title="against", fontsize="small")


def _draw_family(axes: Axes, league: League, camp: str, done: list[int]) -> None:
    """A point a kept model, by its place; a line to the model that it was trained from."""
    places: dict[str, int] = {}
    for k in done:
        parents = {row["name"]: row["parent"] for row in league.standings(k)[camp]}
        now: dict[str, int] = {}
        for place, member in enumerate(league.kept(k)[camp]):
            now.setdefault(member.name, place)
            parent = parents.get(member.name)
            if parent in places:
                axes.plot([k - 1, k], [places[parent], place], color=COLOURS[camp], linewidth=1.0, alpha=0.6)
            axes.plot(k, place, "o", color=COLOURS[camp], markersize=5)
        places = now
    axes.set_yticks(range(league.settings.keep), [str(place + 1) for place in range(league.settings.keep)])
    axes.invert_yaxis()
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(title=f"who comes from whom, {camp}", xlabel="iteration", ylabel="place")
    axes.grid(alpha=0.2)
