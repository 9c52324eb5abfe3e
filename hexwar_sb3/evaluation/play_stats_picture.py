"""Statistics of play as pictures: tasks by phase, Fig. 8, and where a player goes and destroys."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from hexwar_sb3.evaluation.play_stats import PHASES, TYPES, PlayStats
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.picture import cell_corners, draw_map, draw_points
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.pictures import FAINT, INK, colour, dress, new_figure, write_figure
from hexwar_sb3.tasks.records import TaskKind

KINDS = tuple(kind.name.lower() for kind in TaskKind)
SUFFIXES = (".pdf", ".svg", ".png")
GROUND = 4.9  # zorder below which a map is drawn as points, not as thousands of polygons
STEPS = [factor * 10**power for power in range(7) for factor in (1, 2, 5)]


def draw_stats(stats: PlayStats, scenario: Scenario, folder: Path, *, player: str) -> list[Path]:
    """Write `tasks`, `targets` and `places` into a folder, each as PDF, SVG and PNG."""
    figures = {
        "tasks": _tasks(stats, player),
        "targets": _targets(stats, player),
        "places": _places(stats, scenario, player),
    }
    paths = {folder / f"{name}{suffix}": figure for name, figure in figures.items() for suffix in SUFFIXES}
    for path, figure in paths.items():
        write_figure(figure, path)
    return list(paths)


def _tasks(stats: PlayStats, player: str) -> Figure:
    """What a piece of each type is told in each phase, as shares."""
    figure = new_figure(12, 3.8)
    panels = figure.subplots(1, len(PHASES), sharey=True)
    shown = [kind for kind in KINDS[1:] if any(one == kind for _, _, one in stats.tasks)]
    for axes, phase in zip(panels, PHASES, strict=True):
        left = np.zeros(len(TYPES))
        totals = [_total(stats, phase, piece) for piece in TYPES]
        for kind in shown:
            counts = np.array([stats.tasks[phase, piece, kind] for piece in TYPES])
            shares = 100 * counts / np.maximum(1, totals)
            axes.barh(TYPES, shares, left=left, color=colour(shown.index(kind)), label=kind, height=0.65)
            left += shares
        for place, total in enumerate(totals):
            axes.text(101, place, f"{total:,}", fontsize="small", color=FAINT, va="center")
        dress(axes, phase, xlabel="% of the decisions", xlim=(0, 100))
    panels[0].invert_yaxis()
    handles, words = panels[0].get_legend_handles_labels()
    title = f"Tasks of {player} ({stats.games:,} games; beside the bars: decisions other than to stop)"
    figure.legend(
        handles, words, loc="outside upper center", ncols=len(words) or 1, title=title, frameon=False
    )
    return figure


def _total(stats: PlayStats, phase: str, piece: str) -> int:
    return sum(stats.tasks[phase, piece, kind] for kind in KINDS[1:])


def _targets(stats: PlayStats, player: str) -> Figure:
    """Whom each type fires at, beside whom it could have fired at."""
    figure = new_figure(12, 3.6)
    panels = figure.subplots(1, len(TYPES), sharey=True)
    for axes, shooter in zip(panels, TYPES, strict=True):
        _draw_targets(axes, stats.targets, stats.available, shooter)
    panels[0].set_ylabel("% of the shots")
    handles, words = panels[0].get_legend_handles_labels()
    title = f"Targets of {player} in the first half of the game ({stats.games:,} games)"
    figure.legend(handles, words, loc="outside upper center", ncols=2, title=title, frameon=False)
    return figure


def _draw_targets(
    axes: Axes, chosen: Counter[tuple[str, str]], available: Mapping[tuple[str, str], float], shooter: str
) -> None:
    shots = sum(chosen[shooter, target] for target in TYPES)
    for k, (counts, word) in enumerate(((chosen, "fired at"), (available, "could be fired at"))):
        shares = [100 * counts.get((shooter, target), 0) / max(1, shots) for target in TYPES]
        places = np.arange(len(TYPES)) + 0.4 * (k - 0.5)
        axes.bar(places, shares, width=0.38, color=(colour(0), FAINT)[k], label=word)
    axes.set_xticks(range(len(TYPES)), TYPES, rotation=25)
    dress(axes, f"{shooter}, {shots:,} shots", ylim=(0, 100))


def _places(stats: PlayStats, scenario: Scenario, player: str) -> Figure:
    """Where its ground pieces go, and where it destroys."""
    hexmap = scenario.hexmap
    figure = new_figure(14, 0.6 + 5.5 * hexmap.height / hexmap.width)
    for axes, counts, word in zip(
        figure.subplots(1, 2), (stats.visits, stats.kills), ("arrivals", "enemies destroyed"), strict=True
    ):
        draw_map(axes, hexmap)
        axes.set_rasterization_zorder(GROUND)
        _draw_heat(figure, axes, hexmap, counts, word)
        draw_points(axes, scenario)
        axes.set_title(f"{player}: {word}", fontsize="medium", loc="left", color=INK)
    return figure


def _draw_heat(figure: Figure, axes: Axes, hexmap: HexMap, counts: Counter[str], label: str) -> None:
    if not counts:
        return
    cells = [hexmap.parse_cell(cell) for cell in counts]
    shade = LogNorm(1, max(2, *counts.values()))
    heat = PolyCollection(
        list(cell_corners(hexmap)[cells]), cmap="inferno_r", norm=shade, linewidths=0, zorder=5
    )
    heat.set_array(np.array(list(counts.values()), dtype=float))
    heat.set_alpha(0.85)
    axes.add_collection(heat)
    bar = figure.colorbar(heat, ax=axes, label=label, shrink=0.6, pad=0.01, format="%g")
    bar.set_ticks([n for n in STEPS if n <= shade.vmax])
    bar.minorticks_off()
