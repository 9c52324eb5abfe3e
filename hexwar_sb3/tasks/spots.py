"""Hot spots G^L (III-A): the control points and k more cells that tasks lead to.

For the built-in maps the cells come from a file, which says where they come from; `source` is
"static rule" or a count of visits in replays. Any other map gets the static rule: near each
control point a concealed cell, and farther off cells that overlook it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle, islice, product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.maps.document import Document
from hexwar_sb3.maps.geometry import cell_name
from hexwar_sb3.maps.travel import TOO_FAR
from hexwar_sb3.rules.enums import Camp

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

SPOTS = 6  # cells beside the control points
MAX_SPOTS = 32
SCHEMA = 1
FOLDER = Path(__file__).parent / "spots"


@dataclass(frozen=True, kw_only=True)
class Ring:
    """Where, seen from a control point, one more spot is looked for, and what counts there.

    Weights follow the overwatch score of bots.md, section 1; they are settings, no rules.
    """

    nearest: int  # cells from the point
    farthest: int
    line: float  # for a line of sight to the point
    concealed: float
    height: float  # for a cell at least as high as the point
    zone: float  # for each cell within ZONE_CELLS of the point that is seen
    way: float  # against each cell of distance to the camp's start


RINGS = (
    Ring(nearest=1, farthest=3, line=1.0, concealed=4.0, height=0.0, zone=0.0, way=0.05),
    Ring(nearest=4, farthest=8, line=3.0, concealed=2.0, height=1.0, zone=0.15, way=0.05),
    Ring(nearest=9, farthest=14, line=3.0, concealed=2.0, height=1.0, zone=0.15, way=0.05),
)
ZONE_CELLS = 3
APART_CELLS = 2  # two spots are at least this far apart


def load_spots(world: World, k: int = SPOTS) -> npt.NDArray[np.int16]:
    """Cells of G^L for both camps: [2, S], S = control points + k, in the order of each camp's frame.

    A file of the map's name gives red's cells, and blue's are their mirror images; without one,
    or with fewer than k cells in it, each camp gets the static rule in its own frame.
    """
    points = [point.cell for point in world.scenario.points]
    red = _filed_cells(world)
    if red is None or len(red) < k:
        return np.array([points + static_spots(world, camp, k) for camp in (Camp.RED, Camp.BLUE)], np.int16)
    blue = [int(world.cells[cell].mirror) for cell in red]
    return np.array([points + red[:k], points + blue[:k]], np.int16)


def static_spots(world: World, camp: int, k: int) -> list[int]:
    """The static rule: the best cell of each ring around each control point, points in turn."""
    chosen: list[int] = []
    points = [point.cell for point in world.scenario.points]
    reachable = _reachable(world, points)
    for ring, point in islice(cycle(product(RINGS, points)), k):
        free = reachable & _away_from(world, [*points, *chosen])
        chosen.append(_best_cell(world, camp, ring, point, free))
    return chosen


def spots_document(world: World, k: int = SPOTS) -> dict[str, Any]:
    """The static rule's cells in the form of a spots file."""
    width = world.scenario.hexmap.width
    return {
        "schema": SCHEMA,
        "map": world.scenario.hexmap.name,
        "map_hash": world.scenario.hexmap.hash,
        "source": "static rule",
        "cells": [cell_name(cell, width) for cell in static_spots(world, Camp.RED, k)],
    }


def _filed_cells(world: World) -> list[int] | None:
    """Red's cells from the file of this map; None without a file, or if it is of another map.

    Raises:
        FileFormatError: the file cannot be used; it says where and why.
    """
    hexmap = world.scenario.hexmap
    path = FOLDER / f"{hexmap.name}.json"
    if not path.is_file():
        return None
    document = Document.read(path, FileFormatError)
    document.only(("schema", "map", "map_hash", "source", "cells"))
    document.integer("schema", SCHEMA, SCHEMA)
    names = document.texts("cells", range(MAX_SPOTS + 1))
    if document.text("map_hash") != hexmap.hash:
        return None
    return [document.cell("cells", name, hexmap.width, hexmap.height) for name in names]


def _reachable(world: World, points: list[int]) -> Bools:
    """Cells from which both hop classes reach every control point [NC]."""
    ways = world.eta[:, points, :] < TOO_FAR
    return np.asarray(ways.all(axis=(0, 1)) & (world.cells.passable == 1))


def _apart(world: World, cell: int) -> npt.NDArray[np.int64]:
    """Distance of every cell from one cell [NC], cells."""
    dq = world.cells.q.astype(np.int64) - int(world.cells[cell].q)
    dr = world.cells.r.astype(np.int64) - int(world.cells[cell].r)
    return np.asarray((abs(dq) + abs(dr) + abs(dq + dr)) // 2)


def _away_from(world: World, taken: list[int]) -> Bools:
    """Cells that are not too near to any of some others [NC]."""
    away = np.ones(world.cells.size, np.bool_)
    for cell in taken:
        away &= _apart(world, cell) >= APART_CELLS
    return away


def _seen_from(world: World, cell: int) -> Bools:
    """Cells with a line of sight to one cell, both ends on the ground [NC]."""
    return np.unpackbits(world.los[0, cell], bitorder="little")[: world.cells.size].astype(np.bool_)


def _best_cell(world: World, camp: int, ring: Ring, point: int, free: Bools) -> int:
    """The cell of highest score in a ring; ties go to the lower cell number in the camp's frame."""
    apart = _apart(world, point)
    inside = free & (ring.nearest <= apart) & (apart <= ring.farthest)
    score = np.where(inside, _scores(world, camp, ring, point), -np.inf)
    numbers = np.arange(score.size) if camp == Camp.RED else world.cells.mirror
    return int(np.lexsort((numbers, -score))[0])


def _scores(world: World, camp: int, ring: Ring, point: int) -> Floats:
    """Overwatch score of every cell for one control point [NC]."""
    cells = world.cells
    zone = np.flatnonzero((_apart(world, point) <= ZONE_CELLS) & (cells.playable == 1))
    seen = np.sum([_seen_from(world, cell) for cell in zone.tolist()], axis=0)
    starts = [piece.cell for piece in world.scenario.pieces if piece.camp == camp]
    way = np.mean([_apart(world, cell) for cell in starts], axis=0)
    score = ring.line * _seen_from(world, point) + ring.concealed * cells.concealed
    score = score + ring.height * (cells.elev_m >= cells[point].elev_m) + ring.zone * seen
    return np.asarray(score - ring.way * way)
