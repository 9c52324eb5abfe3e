"""A league as a picture: how its best models do against those before it, and who comes from whom."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import CAMPS
from hexwar_sb3.pictures import CAMPS as COLOURS
from hexwar_sb3.pictures import INK, colour, draw_band, dress, new_figure, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Progress = Mapping[str, Mapping[int, Estimate]]  # opponent -> iteration -> win rate of the best model


def draw_league(league: League, progress: Progress, path: Path) -> None:
    """Write the picture.

    Args:
        league: as far as it is.
        progress: win rates of the best models of both colours together, by opponent and iteration.
        path: picture.
    """
    done = [k for k in range(league.settings.iterations + 1) if league.is_done(k)]
    camps = CAMPS if league.settings.split else CAMPS[:1]
    figure = new_figure(5.0 + len(camps) * (1.5 + 0.75 * len(done)), 4.8)
    left, *families = figure.subplots(
        1, 1 + len(camps), width_ratios=[5.0, *len(camps) * [1.5 + 0.75 * len(done)]]
    )
    _draw_progress(left, progress)
    for axes, camp in zip(families, camps, strict=True):
        _draw_family(axes, league, camp, done)
    write_figure(figure, path)


def _draw_progress(axes: Axes, progress: Progress) -> None:
    for k, (opponent, rates) in enumerate(progress.items()):
        iterations = sorted(rates)
        shown = [rates[i] for i in iterations]
        means, lows, highs = ([getattr(rate, end) for rate in shown] for end in ("value", "low", "high"))
        draw_band(axes, iterations, means, lows, highs, color=colour(k), label=opponent)
    words = {"xlabel": "iteration", "ylabel": "win rate, both colours"}
    dress(axes, "the best model of each iteration (band: 95 %)", ylim=(0, 1), **words)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if progress:
        axes.legend(title="against", fontsize="small", loc="lower right")


def _draw_family(axes: Axes, league: League, camp: str, done: list[int]) -> None:
    """A model's name where it was kept, by its place; a line to the model that it was trained from, dashed if it stayed."""
    ink = COLOURS[camp] if league.settings.split else INK
    places: dict[str, int] = {}
    for k in done:
        parents = {row["name"]: row["parent"] for row in league.standings(k)[camp]}
        now: dict[str, int] = {}
        for place, member in enumerate(league.kept(k)[camp]):
            now.setdefault(member.name, place)
            parent = parents.get(member.name)
            if parent in places:
                style = "--" if parent == member.name else "-"
                axes.plot([k - 1, k], [places[parent], place], style, color=ink, linewidth=1.2, alpha=0.6)
            plate = {"boxstyle": "round,pad=0.25", "fc": "white", "ec": ink, "lw": 0.8}
            axes.text(k, place, member.name, ha="center", va="center", fontsize=6.5, color=ink, bbox=plate)
        places = now
    axes.set_yticks(range(league.settings.keep), [str(place + 1) for place in range(league.settings.keep)])
    axes.invert_yaxis()
    axes.set_ylim(league.settings.keep - 0.5, -0.5)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    who = f"{camp} models" if league.settings.split else "models"
    dress(
        axes,
        f"kept {who}, and whom each was trained from (dashed: the same)",
        xlabel="iteration",
        ylabel="place",
    )
    axes.set_xlim(min(done, default=0) - 0.6, max(done, default=0) + 0.6)
