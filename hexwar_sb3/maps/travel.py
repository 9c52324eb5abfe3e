"""Hop times (rule book, section 1) and fastest travel times between all cells."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexwar_sb3.kernels import Row, kernel
from hexwar_sb3.maps.cells import NO_CELL, NO_HOP, Cells
from hexwar_sb3.maps.geometry import Ints, neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.rules.enums import HopClass, PieceType
from hexwar_sb3.rules.indices import cell_range

TOO_FAR = 255  # eta: unreachable, or more than 254 base hops


def base_hops(rules: Row) -> Ints:
    """Ticks of a hop on open ground [HopClass]."""
    return np.array([rules.base_hop[PieceType.TANK], rules.base_hop[PieceType.SOLDIER]], np.int64)


def hop_ticks(hexmap: HexMap, rules: Row) -> Ints:
    """Ticks of the hop from each cell to each neighbour [NC, HopClass, direction]; NO_HOP: none."""
    to = neighbour_cells(hexmap.width, hexmap.height)
    elev_m = hexmap.elev_m.ravel().astype(np.int64)
    climb_m = np.abs(elev_m[to] - elev_m[:, None])
    units = np.empty((hexmap.n_cells, len(HopClass), to.shape[1]), np.int64)
    units[:, HopClass.VEHICLE] = _vehicle_units(hexmap, to, climb_m, rules)
    units[:, HopClass.SOLDIER] = np.where(climb_m > rules.steep_m, rules.steep_factor, 1)
    allowed = (to != NO_CELL) & hexmap.passable.ravel()[to]
    return np.where(allowed[:, None], units * base_hops(rules)[:, None], NO_HOP)


def _vehicle_units(hexmap: HexMap, to: Ints, climb_m: Ints, rules: Row) -> Ints:
    """Base hops that a vehicle needs to each neighbour [NC, direction]; 0: too steep."""
    levels = -(-climb_m // hexmap.grade_m)
    ground = np.where(hexmap.concealed, rules.concealed_factor, 1)
    ground = np.where(hexmap.slushy, rules.slushy_factor, ground).ravel()
    units = np.where(levels > rules.max_climb, 0, np.maximum(levels, 1) * ground[to])
    paved = hexmap.paved.ravel()
    return np.where(paved[:, None] & paved[to], 1, units)


@kernel
def travel_times(cells: Cells, base_hop: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
    """Fastest travel times in base hops [HopClass, target, cell]; TOO_FAR: none."""
    eta = np.full((base_hop.size, cells.size, cells.size), TOO_FAR, np.uint8)
    for hop_class in range(base_hop.size):
        inward = inward_units(cells, hop_class, base_hop[hop_class])
        heap = np.zeros((inward.max() + 1, cells.size), np.int16)
        for target in cell_range(cells.size):
            if cells[target].passable:
                spread_from(target, cells, inward, heap, eta[hop_class, target])
    return eta


@kernel
def inward_units(cells: Cells, hop_class: int, base_hop: int) -> npt.NDArray[np.int64]:
    """Base hops from each neighbour into a cell [cell, direction of the neighbour]; 0: none."""
    units = np.zeros((cells.size, 6), np.int64)
    for c in cell_range(cells.size):
        for d in range(6):
            neighbour = cells[c].neighbour[d]
            if neighbour != NO_CELL:
                back = (d + 3) % 6
                units[c, d] = cells[neighbour].hop_ticks[hop_class, back] // base_hop
    return units


@kernel
def spread_from(
    target: int,
    cells: Cells,
    inward: npt.NDArray[np.int64],
    buckets: npt.NDArray[np.int16],
    eta: npt.NDArray[np.uint8],
) -> None:
    """Fill eta [cell] by Dial's form of Dijkstra's search: one bucket for each time.

    Times of cells in wait differ by less than the number of buckets, so the buckets are a ring.
    """
    ring = buckets.shape[0]
    filled = np.zeros(ring, np.int64)
    eta[target] = 0
    buckets[0, 0] = target
    filled[0] = 1
    for time in range(TOO_FAR):
        now = time % ring
        for k in range(filled[now]):
            c = buckets[now, k]
            if eta[c] != time:
                continue  # reached earlier since it was put here
            for d in range(6):
                neighbour = cells[c].neighbour[d]
                later = time + inward[c, d]
                if inward[c, d] == 0 or later >= eta[neighbour]:
                    continue
                eta[neighbour] = later
                buckets[later % ring, filled[later % ring]] = neighbour
                filled[later % ring] += 1
        filled[now] = 0
