"""A picture of a map: altitude, forest, marsh, water, roads, control points and starts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from hexwar_sb3.maps.geometry import NE, NW, SE, SW, E, Ints, W, neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.ruleset import default_rules

Colours: TypeAlias = npt.NDArray[np.float64]
Field: TypeAlias = npt.NDArray[np.float64]

ALTITUDE = LinearSegmentedColormap.from_list(
    "altitude", ["#cfdcae", "#e3e3b4", "#ecdca6", "#dcbf87", "#c09a6b", "#a27f63", "#d8cdc4"]
)
FOREST, MARSH, LAKE, ROAD = "#3f6b3a", "#6fa8a0", "#7fb2d9", "#fbf3df"
CAMP_COLOUR = {Camp.RED: "#c0392b", Camp.BLUE: "#1f4e9c", Camp.GREEN: "#2e7d32"}
_INK, _NOBODYS = "#33302b", "#f4c430"
_CORNER = np.deg2rad(np.array([90, 30, -30, -90, -150, 150]))  # N, NE, SE, S, SW, NW corner
_SIDE = {W: (4, 5), SW: (3, 4), SE: (2, 3), E: (1, 2), NE: (0, 1), NW: (5, 0)}  # its two corners
_PLATE = {"boxstyle": "round,pad=0.2", "fc": "#ffffffcc", "ec": "none"}  # behind a text
_CELL = 0.165  # inches, width
_LEAST, _MOST = 7.0, 14.0  # inches of the longer side of a map
_BAR, _TITLE, _ROW, _ENTRY, _NARROWEST = 1.0, 0.75, 0.25, 1.75, 3.8  # inches of the other parts of a page
_MARGIN = 1.3  # cells of the usual width between the map and the numbers around it
_LABEL_STEP = 10  # cells between two printed names
_LEAST_SPAN_M = 120  # of altitudes that the colours show
_EDGE_STEP = 5  # columns and rows between two numbers along the edge


def map_picture(hexmap: HexMap, scenario: Scenario | None = None) -> Figure:
    """A map, with the control points and starts of a scenario on it."""
    wide, height = map_inches(hexmap)
    width = max(wide, _NARROWEST)
    entries = _legend_entries()
    rows = math.ceil(len(entries) * _ENTRY / width)
    columns = math.ceil(len(entries) / rows)
    figure = Figure(figsize=(width + _BAR, _TITLE + height + rows * _ROW), layout="constrained")
    axes = figure.add_subplot()
    draw_map(axes, hexmap)
    _draw_names(axes, hexmap, aside=_MARGIN * _CELL * hexmap.width / wide)
    if scenario is not None:
        draw_scenario(axes, scenario)
    figure.legend(handles=entries, loc="outside lower center", ncols=columns, frameon=False, fontsize=9)
    scale = ScalarMappable(_altitudes(hexmap), ALTITUDE)
    figure.colorbar(scale, ax=axes, label="altitude, m", shrink=0.6, pad=0.01)
    figure.suptitle(f"{hexmap.name} ({int(hexmap.playable.sum()):,} cells)", fontsize=13, parse_math=False)
    return figure


def map_inches(hexmap: HexMap) -> tuple[float, float]:
    """Width and height of a map on a page: cells are equally large on all maps, as far as the page allows."""
    cells = np.array([hexmap.width, hexmap.height * np.sqrt(3) / 2])
    width, height = cells * np.clip(_CELL, _LEAST / cells.max(), _MOST / cells.max())
    return float(width), float(height)


def centres(hexmap: HexMap) -> Field:
    """Where cells are drawn [NC, (x, y)], one cell wide; north is up."""
    y, x = np.divmod(np.arange(hexmap.n_cells), hexmap.width)
    return np.stack([x + (y & 1) / 2, -y * np.sqrt(3) / 2], axis=1)


def draw_map(axes: Axes, hexmap: HexMap) -> None:
    """The terrain alone, on given axes."""
    playable = np.flatnonzero(hexmap.playable)
    corners = cell_corners(hexmap)[playable]
    colours = _colours(hexmap)[playable]
    axes.add_collection(
        PolyCollection(list(corners), facecolors=colours, edgecolors="#00000018", linewidths=0.3)
    )
    _draw_glyphs(axes, hexmap)
    _draw_shores_and_cliffs(axes, hexmap)
    _draw_roads(axes, hexmap)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def draw_scenario(axes: Axes, scenario: Scenario) -> None:
    """Control points and starts, on axes that hold the map."""
    draw_points(axes, scenario)
    cells: dict[int, list[tuple[Camp, str]]] = {}
    for piece in scenario.pieces:
        cells.setdefault(piece.cell, []).append((piece.camp, piece.kind.name[0]))
    draw_tokens(axes, scenario.hexmap, cells)


def draw_points(axes: Axes, scenario: Scenario, owners: Sequence[Camp] = ()) -> None:
    """Control points with their values, in the colours of their owners where those are given."""
    where = centres(scenario.hexmap)
    for k, point in enumerate(scenario.points):
        x, y = where[point.cell]
        owner = owners[k] if owners else Camp.GREEN
        colour = _NOBODYS if owner == Camp.GREEN else CAMP_COLOUR[owner]
        axes.plot(x, y, marker="*", markersize=17, color=colour, markeredgecolor=_INK, zorder=6)
        _write(axes, (x, y + 1.6), f"{point.name} {point.value}", fontsize=9, weight="bold", bbox=_PLATE)


def draw_tokens(axes: Axes, hexmap: HexMap, cells: Mapping[int, Sequence[tuple[Camp, str]]]) -> None:
    """Pieces as letters on plates of their camp's colour, by cell."""
    where = centres(hexmap)
    for cell, tokens in cells.items():
        plate = _PLATE | {"fc": CAMP_COLOUR[tokens[0][0]], "ec": "white"}
        letters = "+".join(letter for _, letter in tokens)
        _write(axes, where[cell], letters, fontsize=7, weight="bold", color="white", bbox=plate)


def cell_corners(hexmap: HexMap) -> Field:
    """Corners of every cell [NC, 6, (x, y)]."""
    ring = np.stack([np.cos(_CORNER), np.sin(_CORNER)], axis=1) / np.sqrt(3)
    return centres(hexmap)[:, None, :] + ring


def _colours(hexmap: HexMap) -> Colours:
    """Colour of every cell [NC, RGB]: altitude with light from the north-west, then cover."""
    colours = ALTITUDE(_altitudes(hexmap)(hexmap.elev_m.ravel()))[:, :3] * _light(hexmap)[:, None]
    for layer, colour, share in ((hexmap.concealed, FOREST, 0.55), (hexmap.slushy, MARSH, 0.6)):
        marks = layer.ravel()
        colours[marks] = (1 - share) * colours[marks] + share * np.array(to_rgb(colour))
    colours[~hexmap.passable.ravel()] = to_rgb(LAKE)
    return np.clip(colours, 0, 1)


def _altitudes(hexmap: HexMap) -> Normalize:
    """The altitudes that the colours span: low ground looks low on every map."""
    return Normalize(0, max(_LEAST_SPAN_M, int(hexmap.elev_m.max())))


def _light(hexmap: HexMap) -> Field:
    """Brightness of every cell by its slope [NC], 1 on level ground."""
    neighbours = neighbour_cells(hexmap.width, hexmap.height)
    elev_m = hexmap.elev_m.ravel().astype(float)
    around = np.where(neighbours < 0, elev_m[:, None], elev_m[neighbours])
    slope = around[:, [SE, E]].sum(axis=1) - around[:, [NW, W]].sum(axis=1)
    strength = 0.22 * slope / max(1.0, float(np.abs(slope).max()) * 0.6)
    return 1 + np.clip(strength, -0.22, 0.22)


def _draw_glyphs(axes: Axes, hexmap: HexMap) -> None:
    """Trees in forests, rushes in marshes, houses in built-up cells."""
    where = centres(hexmap)
    built_up = (hexmap.concealed & hexmap.paved).ravel()
    forest = hexmap.concealed.ravel() & ~built_up
    marsh = hexmap.slushy.ravel() & ~forest
    for dx, dy in ((-0.2, 0.12), (0.18, 0.18), (0.02, -0.2)):
        x, y = (where[forest] + (dx, dy)).T
        axes.scatter(x, y, s=7, marker="^", color="#234a24", linewidths=0, zorder=3)
    for dx, dy in ((-0.14, 0.14), (0.14, 0.0), (-0.14, -0.14)):
        x, y = (where[marsh] + (dx, dy)).T
        axes.scatter(x, y, s=5, marker="_", color="#2f6f68", linewidths=0.8, zorder=3)
    for dx, dy in ((-0.2, 0.2), (0.22, 0.16), (-0.16, -0.24), (0.2, -0.2)):
        x, y = (where[built_up] + (dx, dy)).T
        axes.scatter(x, y, s=7, marker="s", color="#5b4a3f", linewidths=0, zorder=5)


def _draw_shores_and_cliffs(axes: Axes, hexmap: HexMap) -> None:
    """Edges of lakes, and edges too steep for a vehicle."""
    sides = _sides(hexmap)
    a, b, _ = sides.T
    passable, elev_m = hexmap.passable.ravel(), hexmap.elev_m.ravel().astype(int)
    limit_m = default_rules().number("max_climb") * hexmap.grade_m
    shore = passable[a] != passable[b]
    cliff = passable[a] & passable[b] & (abs(elev_m[a] - elev_m[b]) > limit_m)
    for chosen, colour, thickness in ((shore, "#4a86b5", 1.2), (cliff, "#5a3a22", 2.0)):
        lines = _side_lines(hexmap, sides[chosen])
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=thickness, zorder=3))


def _draw_roads(axes: Axes, hexmap: HexMap) -> None:
    a, b, _ = _sides(hexmap).T
    paved = hexmap.paved.ravel()
    both = paved[a] & paved[b]
    where = centres(hexmap)
    lines = list(np.stack([where[a[both]], where[b[both]]], axis=1))
    for colour, thickness in ((_INK, 3.2), (ROAD, 2.0)):
        axes.add_collection(
            LineCollection(lines, colors=colour, linewidths=thickness, capstyle="round", zorder=4)
        )


def _sides(hexmap: HexMap) -> Ints:
    """Every pair of neighbours once [pair, (cell, neighbour, direction)]."""
    neighbours = neighbour_cells(hexmap.width, hexmap.height)
    pairs = [
        np.stack([cells, neighbours[cells, d], np.full(cells.size, d)], axis=1)
        for d in (E, SE, SW)
        for cells in [np.flatnonzero(neighbours[:, d] >= 0)]
    ]
    return np.concatenate(pairs)


def _side_lines(hexmap: HexMap, sides: Ints) -> list[Field]:
    corners = cell_corners(hexmap)
    return [corners[a][list(_SIDE[d])] for a, _, d in sides.tolist()]


def _draw_names(axes: Axes, hexmap: HexMap, aside: float) -> None:
    """Every tenth cell's name, and every fifth column and row along the edges, so many cells aside."""
    where = centres(hexmap).reshape(hexmap.height, hexmap.width, 2)
    halo = [withStroke(linewidth=1.6, foreground="#ffffffb0")]
    for y in range(_LABEL_STEP - 1, hexmap.height, _LABEL_STEP):
        for x in range(_LABEL_STEP - 1, hexmap.width - 1, _LABEL_STEP):
            name = hexmap.cell_name(y * hexmap.width + x)
            _write(axes, where[y, x], name, fontsize=5.5, path_effects=halo)
    for x in range(_EDGE_STEP - 1, hexmap.width, _EDGE_STEP):
        for place in (where[0, x] + (0, aside), where[-1, x] - (0, aside)):
            _write(axes, place, f"{x + 1:02d}", fontsize=7)
    for y in range(_EDGE_STEP - 1, hexmap.height, _EDGE_STEP):
        for place in (where[y, 0] - (aside, 0), where[y, -1] + (aside, 0)):
            _write(axes, place, f"{y + 1:02d}", fontsize=7)


def _write(axes: Axes, place: Sequence[float] | Field, text: str, **style: Any) -> None:
    usual: dict[str, Any] = {"ha": "center", "va": "center", "color": _INK, "zorder": 7, "parse_math": False}
    axes.text(float(place[0]), float(place[1]), text, **(usual | style))


def _legend_entries() -> list[Patch | Line2D]:
    edge = [withStroke(linewidth=4, foreground=_INK)]
    return [
        Patch(color=FOREST, label="concealed"),
        Patch(color=MARSH, label="slushy"),
        Patch(color=LAKE, label="impassable"),
        Line2D([], [], color=ROAD, linewidth=2, label="paved", path_effects=edge),
        Line2D([], [], color="#5a3a22", linewidth=2, label="too steep for vehicles"),
    ]
