"""A picture of hot spots: visits as heat, G^L numbered, its hull G^B, and the walls, on the map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from hexwar_sb3.engine.picture import PICTURES
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.picture import CAMP_COLOUR, centres, draw_map, draw_scenario
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.spots_file import HotSpots

Places = NDArray[np.float64]

_HEAT = LinearSegmentedColormap.from_list("visits", ["#ffdf5e", "#fb9a3c", "#e8590c", "#9c1140", "#4a0838"])
_WALL = "#5a3a22"
_SIDE = 1 / np.sqrt(3)  # of a hexagon one unit wide
_CORNERS = _SIDE * np.stack([f(np.deg2rad(np.arange(90, -270, -60))) for f in (np.cos, np.sin)], axis=1)
_ABOVE, _ASIDE = 1.05, 0.6  # cells from a spot to its number; aside where both camps have the spot


def check_picture(path: Path) -> None:
    """Check the name of a picture.

    Raises:
        ConfigError: its ending is of no kind that can be drawn, or it is a folder.
    """
    if path.suffix not in PICTURES or path.is_dir():
        raise ConfigError(f"{path}: a picture's name must end in one of {', '.join(PICTURES)}")


def save_spots_picture(spots: HotSpots, scenario: Scenario, path: str | Path) -> None:
    """Draw hot spots into a file (png, svg or pdf by its suffix)."""
    check_picture(Path(path))
    with replacing(Path(path)) as temporary:
        spots_picture(spots, scenario).savefig(temporary, dpi=110)


def spots_picture(spots: HotSpots, scenario: Scenario) -> Figure:
    """The map, paled, with the visits of both camps, their spots and hulls, and the walls."""
    figure = Figure(figsize=(12, 10.5), layout="constrained")
    axes = figure.add_subplot()
    draw_map(axes, spots.hexmap)
    _pale(axes)
    _draw_walls(axes, spots)
    _draw_visits(figure, axes, spots)
    draw_scenario(axes, scenario)
    for camp in SIDES:
        _draw_hull(axes, spots, camp)
        _draw_numbers(axes, spots, camp)
    _draw_legend(axes, spots)
    axes.set_title(f"{spots.hexmap.name}: hot spots\n{spots.source}", fontsize=10, wrap=True)
    return figure


def _pale(axes: Axes) -> None:
    veil = Rectangle(
        (0, 0), 1, 1, transform=axes.transAxes, color="white", alpha=0.5, linewidth=0, zorder=4.5
    )
    axes.add_patch(veil)


def _draw_walls(axes: Axes, spots: HotSpots) -> None:
    """The common side of each pair of cells."""
    if not spots.walls:
        return
    first, second = centres(spots.hexmap)[np.array(spots.walls).T]
    ahead = second - first
    aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) * _SIDE / 2
    middle = (first + second) / 2
    lines = list(np.stack([middle - aside, middle + aside], axis=1))
    axes.add_collection(LineCollection(lines, colors=_WALL, linewidths=1.6, capstyle="round", zorder=4.8))


def _draw_visits(figure: Figure, axes: Axes, spots: HotSpots) -> None:
    """Visits of both camps together; cells that nobody visited stay as they are."""
    heat = np.zeros(spots.hexmap.n_cells)
    for camp in spots.camps:
        heat[list(camp.visits)] += list(camp.visits.values())
    cells = np.flatnonzero(heat)
    if not cells.size:
        return
    hexagons = list(centres(spots.hexmap)[cells][:, None, :] + _CORNERS)
    shade = LogNorm(1, max(2, heat.max()))
    drawn = PolyCollection(hexagons, cmap=_HEAT, norm=shade, edgecolors="#4a083860", linewidths=0.4, zorder=5)
    drawn.set_array(heat[cells])
    axes.add_collection(drawn)
    figure.colorbar(drawn, ax=axes, label="visits of both camps", shrink=0.6, pad=0.01, format="%g")


def _draw_hull(axes: Axes, spots: HotSpots, camp: Camp) -> None:
    corners = spots.camps[camp].hull
    x, y = centres(spots.hexmap)[[*corners, *corners[:1]]].T
    axes.plot(x, y, color=CAMP_COLOUR[camp], linewidth=1.6, linestyle=(0, (6, 3)), zorder=5.5)


def _draw_numbers(axes: Axes, spots: HotSpots, camp: Camp) -> None:
    """Each spot framed in its camp's colour, its rank on a disc above it, beside the other camp's."""
    where, colour = centres(spots.hexmap), CAMP_COLOUR[camp]
    other = spots.camps[1 - camp].cells[: spots.k]
    cells = list(spots.camps[camp].cells[: spots.k])
    frames = list(where[cells][:, None, :] + _CORNERS)
    axes.add_collection(
        PolyCollection(frames, facecolors="none", edgecolors=colour, linewidths=1.8, zorder=8)
    )
    for number, cell in enumerate(cells, start=1):
        x, y = where[cell] + (_ASIDE * (2 * camp - 1) if cell in other else 0, _ABOVE)
        disc = {"boxstyle": "circle,pad=0.22", "fc": colour, "ec": "white", "lw": 0.8}
        axes.text(
            x, y, str(number), fontsize=6.5, zorder=9, bbox=disc,
            ha="center", va="center", color="white", weight="bold",
        )  # fmt: skip


def _draw_legend(axes: Axes, spots: HotSpots) -> None:
    entries = [
        *(
            Line2D(
                [], [], color=CAMP_COLOUR[camp], linestyle=(0, (6, 3)), marker="o", markersize=9,
                label=f"{camp_name(camp)}: spots 1 to {spots.k} of $G^L$ and hull $G^B$",
            )
            for camp in SIDES
        ),
        Line2D([], [], color=_WALL, linewidth=1.6, label="wall: too steep for vehicles"),
    ]  # fmt: skip
    axes.legend(
        handles=entries, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=3, frameon=False, fontsize=9
    )
