"""What a map offers, worked out once before any game: firing posts, nests, dangers of distances.

Everything is listed in the camp's frame: on a mirror-symmetric map blue's tables are red's, mirrored.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from hexwar_sb3.bots.config import ATTACK, CONFIG, DEFENCE, compiled
from hexwar_sb3.bots.records import ATLAS, BAND_CELLS, POSTS, REACH, SHELTERS, SPENT, UPHILL, AtlasRecord
from hexwar_sb3.engine.fire import height_correction
from hexwar_sb3.engine.pieces import target_class
from hexwar_sb3.engine.records import NO_CELL
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.maps.sightlines import line_of_sight
from hexwar_sb3.rules.compiled import NO_POOL, RulesRecord
from hexwar_sb3.rules.enums import Camp, HopClass, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, cell_range
from hexwar_sb3.tasks.shots import expected_value

AROUND_CELLS = 5
RING_CELLS = ((6, 3), (8, 4), (12, 6), (14, 7))  # distance and step along the ring: 12 cells each
VIEW_CELLS = 3  # around a control point, for the worth of a post
NO_WAY = 255  # eta: cannot be reached


@lru_cache(maxsize=8)
def make_atlas(world: World) -> Rows:
    """The atlas of a world [1], read-only."""
    atlas = np.zeros(1, ATLAS).view(np.recarray)
    row = atlas[0]
    row.config = compiled(CONFIG)
    row.style[0], row.style[1] = compiled(ATTACK), compiled(DEFENCE)
    row.width, row.height = world.scenario.hexmap.width, world.scenario.hexmap.height
    values = [point.value for point in world.scenario.points]
    row.rank[: len(values)] = np.argsort(-np.array(values, np.int64), kind="stable")
    row.around[:] = _offsets(0, AROUND_CELLS, 1)
    row.ring[:] = _ring_offsets()
    fill_danger(row.danger, world.rules[0])
    row.best_gain[:] = (1.0 + CONFIG.second_share) * row.danger.max(axis=(1, 2, 3, 4))[:SPENT]
    row.post[:] = NO_CELL
    for camp in (Camp.RED, Camp.BLUE):
        own = world.scenario.pieces[world.side(camp)]
        if own:
            row.home[camp] = own[0].cell
            _fill_points(row, camp, world)
    atlas.flags.writeable = False
    return atlas


def _offsets(nearest: int, farthest: int, step: int) -> npt.NDArray[np.int8]:
    """Cube steps (dq, dr) to all cells at these distances, nearest first, then by angle."""
    sides = ((0, 1), (1, 0), (1, -1), (0, -1), (-1, 0), (-1, 1))
    found = [(0, 0)] if nearest == 0 else []
    for radius in range(max(nearest, 1), farthest + 1):
        q, r = -radius, 0
        ring = []
        for dq, dr in sides:
            for _ in range(radius):
                ring.append((q, r))
                q, r = q + dq, r + dr
        found += ring[::step]
    return np.array(found, np.int8)


def _ring_offsets() -> npt.NDArray[np.int8]:
    return np.concatenate([_offsets(apart, apart, step) for apart, step in RING_CELLS])


def _fill_points(row: Row, camp: int, world: World) -> None:
    for k, point in enumerate(world.scenario.points):
        for band, (nearest, farthest) in enumerate(BAND_CELLS):
            cells = _best_posts(CampIndex(camp), CellIndex(point.cell), nearest, farthest, row, world)
            row.post[camp, k, band, : len(cells)] = cells


def _best_posts(
    camp: CampIndex, point: CellIndex, nearest: int, farthest: int, row: Row, world: World
) -> npt.NDArray[np.int64]:
    """The best firing cells of one band, best first; ties by the cell in the camp's frame."""
    worth = np.full(world.cells.size, -np.inf)
    ways = world.terrain.times_from(HopClass.VEHICLE, int(row.home[camp]))
    rate_posts(point, nearest, farthest, ways, world.cells, world.los, worth)
    return _best(worth, camp, world.cells, POSTS)


def _best(worth: npt.NDArray[np.float64], camp: int, cells: Rows, count: int) -> npt.NDArray[np.int64]:
    found = np.flatnonzero(worth > -np.inf)
    frame = cells.mirror[found] if camp == Camp.BLUE else found
    order = np.lexsort((frame, -worth[found]))[:count]
    return found[order]


@kernel
def rate_posts(
    point: CellIndex,
    nearest: int,
    farthest: int,
    ways: Rows,
    cells: Cells,
    los: Sightlines,
    worth: Rows,
) -> None:
    """Write to worth[cell] how good each cell is as a firing post of a control point (bots.md, section 1).

    ways: base hops of a vehicle from home to each cell [NC].
    """
    last = cells[CellIndex(cells.size - 1)]
    width, height = int(last.x) + 1, int(last.y) + 1
    left, right = max(0, cells[point].x - VIEW_CELLS - 1), min(width, cells[point].x + VIEW_CELLS + 2)
    top, bottom = max(0, cells[point].y - VIEW_CELLS), min(height, cells[point].y + VIEW_CELLS + 1)
    for cell in cell_range(cells.size):
        apart = cells_apart(cells, cell, point)
        way = ways[cell]
        if apart < nearest or apart > farthest or cells[cell].passable == 0 or way == NO_WAY:
            continue
        if not line_of_sight(los, 0, cell, point, cells):
            continue
        seen = 0
        for y in range(top, bottom):
            for x in range(left, right):
                near = CellIndex(y * width + x)
                if cells_apart(cells, near, point) <= VIEW_CELLS and line_of_sight(los, 0, cell, near, cells):
                    seen += 1
        score = 0.1 * seen - 0.1 * way
        if cells[cell].concealed:
            score += 4.0
        if cells[cell].level >= cells[point].level:
            score += 1.0
        worth[cell] = score


@kernel
def fill_danger(danger: Rows, rules: RulesRecord) -> None:
    """Expected points of the best weapon's shot, at full blood on both sides.

    Args:
        danger: [shooter or SPENT, target, sheltered, grade steps uphill, distance].
    """
    for target in range(danger.shape[1]):
        for shelter in range(SHELTERS):
            for uphill in range(UPHILL):
                for apart in range(min(REACH, rules.level.shape[3])):
                    for row in range(SPENT + 1):
                        danger[row, target, shelter, uphill, apart] = best_value(
                            row, target, shelter, uphill, apart, rules
                        )


@kernel
def best_value(row: int, target: int, shelter: int, uphill: int, apart: int, rules: RulesRecord) -> float:
    """Expected points of the best weapon of a shooter (a row of the danger table) at a distance."""
    best = 0.0
    kind = PieceType.CHARIOT if row == SPENT else row
    blood = int(rules.blood[kind])
    mods = shelter * int(rules.mod_target_concealed)
    for weapon in range(rules.pool.shape[1]):
        if rules.pool[kind, weapon] == NO_POOL or (row == SPENT and weapon == Weapon.HEAVY):
            continue
        level = int(rules.level[weapon, target_class(target), blood, apart])
        if kind != PieceType.AEROCRAFT and target != PieceType.AEROCRAFT and level > 0:
            level = max(0, level + height_correction(uphill, apart, rules))
        if level > 0:
            value = expected_value(weapon, blood, level, mods, target, int(rules.blood[target]), False, rules)
            best = max(best, value)
    return best


@kernel
def cell_at(
    cell: CellIndex, dq: int, dr: int, camp: CampIndex, cells: Cells, atlas: AtlasRecord
) -> CellIndex:
    """The cell a cube step away, the step taken in the camp's frame; NO_CELL off the map."""
    if camp == Camp.BLUE:
        dq = -dq - dr
    r = cells[cell].r + dr
    if r < 0 or r >= atlas.height:
        return NO_CELL
    x = cells[cell].q + dq + (r - (r & 1)) // 2
    if x < 0 or x >= atlas.width:
        return NO_CELL
    there = CellIndex(r * atlas.width + x)
    return there if cells[there].playable else NO_CELL
