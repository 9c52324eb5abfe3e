"""Hop times (rule book, section 1) and fastest travel times, to the targets that somebody asks for."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import numpy.typing as npt

from hexwar_sb3.kernels import Row, kernel
from hexwar_sb3.maps.cells import NO_CELL, NO_HOP, Cells, TravelTimes
from hexwar_sb3.maps.geometry import Ints, neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import HopClass, PieceType
from hexwar_sb3.rules.indices import CellIndex, cell_range

TOO_FAR = 255  # base hops: unreachable, or more than 254
MOST_BYTES, LEAST_ROWS = 512_000_000, 256  # of the rows that are kept; memory is taken as they are filled
_HEAD, _TAIL = 2 * len(HopClass), 4  # rows before them; bytes behind each
_MOST_ROWS = 65_535 - _HEAD  # a row's number has two bytes


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


def no_times(n_cells: int) -> TravelTimes:
    """Travel times of a map that nobody asked for yet; kernels fill them. Not to be shared between threads.

    One array of bytes, as every further array that a kernel takes costs it time. A row has the base hops from every
    cell to one target, and behind them the number of that target; the first rows say which row a target has.
    """
    n_rows = min(len(HopClass) * n_cells, max(LEAST_ROWS, MOST_BYTES // n_cells))
    eta = np.zeros((_HEAD + min(n_rows, _MOST_ROWS), n_cells + _TAIL), np.uint8)
    _put_number(0, _HEAD, cast("Any", eta))
    return cast("Any", eta)


def asked(eta: TravelTimes) -> int:
    """Rows that were asked for so far."""
    return int((np.asarray(eta)[_HEAD:, -_TAIL:] != 0).any(axis=1).sum())


@kernel
def row_to(hop_class: int, target: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes) -> int:
    """The row of a target: eta[row, start] is the fastest travel time from a cell in base hops; TOO_FAR: no way."""
    row = row_of(hop_class, target, eta)
    return row if row > 0 else ask(hop_class, target, rules, cells, eta)


@kernel
def row_of(hop_class: int, target: CellIndex, eta: TravelTimes) -> int:
    """The row of a target; 0: none."""
    return int(eta[2 * hop_class, target]) + 256 * int(eta[2 * hop_class + 1, target])


@kernel
def ask(hop_class: int, target: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes) -> int:
    """Fill the row of a target; where all are taken, it gets that of who asked first."""
    row = _get_number(0, eta)
    before = _get_number(row, eta)
    if before > 0:
        _set_row_of((before - 1) // cells.size, (before - 1) % cells.size, 0, eta)
    times = travel_times(hop_class, target, False, rules, cells)
    for cell in cell_range(cells.size):
        eta[row, cell] = times[cell]
    _put_number(row, hop_class * cells.size + target + 1, eta)
    _set_row_of(hop_class, target, row, eta)
    _put_number(0, row + 1 if row + 1 < eta.shape[0] else _HEAD, eta)
    return row


@kernel
def _set_row_of(hop_class: int, target: int, row: int, eta: TravelTimes) -> None:
    eta[2 * hop_class, target] = row & 255
    eta[2 * hop_class + 1, target] = row >> 8


@kernel
def _get_number(row: int, eta: TravelTimes) -> int:
    """What stands at the end of a row: in the first one the row to be filled next, else a target + 1 or 0."""
    number = 0
    for k in range(_TAIL):
        number += int(eta[row, eta.shape[1] - _TAIL + k]) << 8 * k
    return number


@kernel
def _put_number(row: int, number: int, eta: TravelTimes) -> None:
    for k in range(_TAIL):
        eta[row, eta.shape[1] - _TAIL + k] = number >> 8 * k & 255


@kernel
def travel_times(
    hop_class: int, place: CellIndex, outward: bool, rules: RulesRecord, cells: Cells
) -> npt.NDArray[np.uint8]:
    """Fastest travel times between every cell and a place, to it or from it, in base hops [NC]; TOO_FAR: no way.

    Dial's form of Dijkstra's search: one bucket for each time. Times of cells in wait differ by less than the number
    of buckets, so the buckets are a ring.
    """
    times = np.full(cells.size, TOO_FAR, np.uint8)
    if not outward and not cells[place].passable:
        return times
    base = int(rules.base_hop[PieceType.SOLDIER if hop_class == HopClass.SOLDIER else PieceType.TANK])
    ring = longest_hop(hop_class, cells) // base + 1
    buckets = np.empty((ring, cells.size), np.int32)
    filled = np.zeros(ring, np.int64)
    times[place] = 0
    buckets[0, 0] = place
    filled[0] = 1
    for time in range(TOO_FAR):
        now = time % ring
        for k in range(filled[now]):
            cell = buckets[now, k]
            if times[cell] != time:
                continue  # reached earlier since it was put here
            for d in range(6):
                neighbour = cells[cell].neighbour[d]
                if neighbour == NO_CELL:
                    continue
                if outward:
                    hop = cells[cell].hop_ticks[hop_class, d]
                else:
                    hop = cells[neighbour].hop_ticks[hop_class, (d + 3) % 6]
                later = time + hop // base
                if hop == NO_HOP or later >= times[neighbour]:
                    continue
                times[neighbour] = later
                buckets[later % ring, filled[later % ring]] = neighbour
                filled[later % ring] += 1
        filled[now] = 0
    return times


@kernel
def longest_hop(hop_class: int, cells: Cells) -> int:
    """Ticks of the longest hop on the map."""
    longest = 0
    for cell in cell_range(cells.size):
        for d in range(6):
            longest = max(longest, int(cells[cell].hop_ticks[hop_class, d]))
    return longest
