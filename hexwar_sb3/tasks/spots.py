"""Hot spots G^L (III-A): the control points and k more cells that tasks lead to.

For the built-in maps the cells come from a file (`spots_file.py`), which says where they come from:
games whose visits were counted (`hotspots.py`). Any other map gets the static rule: near each
control point a concealed cell, and farther off cells that overlook it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle, islice, product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.maps.document import Document
from hexwar_sb3.maps.sightlines import GROUND_GROUND, in_sight
from hexwar_sb3.maps.travel import TOO_FAR
from hexwar_sb3.rules.enums import Camp, HopClass
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.spots_file import SCHEMA, HotSpots, read_spots, spots_from

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

SPOTS = 6  # cells beside the control points
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
BATTLE_CELLS = 14  # from a control point; the farthest ring ends there
APART_CELLS = 2  # two spots are at least this far apart


def load_spots(world: World, k: int = SPOTS, path: str | Path | None = None) -> npt.NDArray[np.int32]:
    """Cells of G^L(k) for both camps: [2, S], S = control points + k, in the order of each camp's frame.

    Args:
        world: of the scenario.
        k: spots beside the control points; of the usual ones as many as there is room for in a task set.
        path: a file of this map; None: the shipped one, or the static rule where there is none, it is
            of another map or an older schema, or it has fewer than k cells.

    Raises:
        ConfigError: k is out of range.
        FileFormatError: the file cannot be used, or the one named by `path` is of another map.
    """
    check_spots(world, k)
    k = min(k, max_spots(world))
    points = [point.cell for point in world.scenario.points]
    spots = _shipped(world) if path is None else _named(world, k, Path(path))
    if spots is None or min(len(camp.cells) for camp in spots.camps) < k:
        return np.array([points + static_spots(world, camp, k) for camp in (Camp.RED, Camp.BLUE)], np.int32)
    return np.array([points + list(camp.cells[:k]) for camp in spots.camps], np.int32)


def max_spots(world: World) -> int:
    """Largest k: hold and hide at every spot fit in a task set, beside stop and recover."""
    return (MAX_TASKS - 2) // 2 - len(world.scenario.points)


def check_spots(world: World, k: int) -> None:
    """Check the number of spots beside the control points.

    Raises:
        ConfigError: it is out of range.
    """
    most = max(SPOTS, max_spots(world))
    if not 0 <= k <= most:
        n_points = len(world.scenario.points)
        why = f"a task set has {MAX_TASKS} rows, and the scenario {n_points} control points"
        raise ConfigError(f"k must be in 0..{most}, got {k}: {why}")


def static_spots(world: World, camp: int, k: int) -> list[int]:
    """The static rule: the best cell of each ring around each control point, points in turn."""
    chosen: list[int] = []
    points = [point.cell for point in world.scenario.points]
    allowed = reachable(world, points)
    for ring, point in islice(cycle(product(RINGS, points)), k):
        free = allowed & away_from(world, [*points, *chosen])
        chosen.append(_best_cell(world, camp, ring, point, free if free.any() else allowed))
    return chosen


def _shipped(world: World) -> HotSpots | None:
    """The shipped hot spots of this map; None without a file, or if it is of other content."""
    hexmap = world.scenario.hexmap
    shipped = {path.stem: path for path in FOLDER.glob("*.json")}  # a map's name, a stranger's, is no path
    if hexmap.name not in shipped:
        return None
    document = Document.read(shipped[hexmap.name], FileFormatError)
    if (document.data.get("schema"), document.data.get("map_hash")) != (SCHEMA, hexmap.hash):
        return None
    return spots_from(document, hexmap)


def _named(world: World, k: int, path: Path) -> HotSpots:
    """The hot spots of a file that the user named."""
    spots = read_spots(path, world.scenario.hexmap)
    found = min(len(camp.cells) for camp in spots.camps)
    if found < k:
        raise FileFormatError(path, "cells", found=f"{found} of a camp", expected=f"at least k = {k}")
    return spots


def reachable(world: World, points: list[int]) -> Bools:
    """Cells from which both hop classes reach every control point [NC]."""
    ways = [world.terrain.times_to(hop_class, point) < TOO_FAR for hop_class in HopClass for point in points]
    return np.asarray(np.all(ways, axis=0) & (world.cells.passable == 1))


def overlooking(world: World, point: int) -> Bools:
    """Cells of the battle for one control point: near enough, with a line of sight to it [NC]."""
    return np.asarray((_apart(world, point) <= BATTLE_CELLS) & _seen_from(world, point))


def _apart(world: World, cell: int) -> npt.NDArray[np.int64]:
    """Distance of every cell from one cell [NC], cells."""
    dq = world.cells.q.astype(np.int64) - int(world.cells[cell].q)
    dr = world.cells.r.astype(np.int64) - int(world.cells[cell].r)
    return np.asarray((abs(dq) + abs(dr) + abs(dq + dr)) // 2)


def away_from(world: World, taken: list[int], least: int = APART_CELLS) -> Bools:
    """Cells that are not nearer than `least` cells to any of some others [NC]."""
    away = np.ones(world.cells.size, np.bool_)
    for cell in taken:
        away &= _apart(world, cell) >= least
    return away


def _seen_from(world: World, cell: int) -> Bools:
    """Cells with a line of sight to one cell, both ends on the ground [NC]."""
    return in_sight(world.los, GROUND_GROUND, cell, world.cells)


def _best_cell(world: World, camp: int, ring: Ring, point: int, free: Bools) -> int:
    """The free cell of highest score in a ring, or anywhere if it has none; ties go to the lower number in the camp's frame."""
    apart = _apart(world, point)
    inside = free & (ring.nearest <= apart) & (apart <= ring.farthest)
    if not inside.any():
        inside = free
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
