"""Who sees whom over the terrain (rule book, section 6), exact in integers.

The cells that a line crosses depend only on the two cells' offset in cube coordinates. So the
offsets within the longest sight range are walked once each, for all cells that they start from.
A line that passes exactly between two cells is tried on either side of them, and is blocked
only if both sides are. Void blocks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import NO_CELL, Cells, Sightlines
from hexwar_sb3.rules.indices import CellIndex, camp_range, cell_range

VOID_TOP_M = 1_000_000  # higher than any line of sight
GROUND_GROUND, AIR_GROUND, AIR_AIR = 0, 1, 2  # first axis of `los`: number of airborne ends


@kernel
def line_of_sight(los: Sightlines, airborne: int, a: CellIndex, b: CellIndex, cells: Cells) -> bool:
    """Whether b is in line of sight of a, and within the longest range; with one airborne end, a is that end."""
    reach = los.shape[1] >> 1
    down, right = cells[b].r - cells[a].r + reach, cells[b].q - cells[a].q + reach
    if down < 0 or down > 2 * reach or right < 0 or right > 2 * reach:
        return False
    return (los[airborne * cells.size + a, down, right >> 3] >> (right & 7)) & 1 == 1


def in_sight(los: Any, airborne: int, a: int, cells: Rows) -> npt.NDArray[np.bool_]:
    """All cells b that are in line of sight of a [NC]."""
    reach = los.shape[1] // 2
    down, right = (cells[axis].astype(np.int64) - int(cells[axis][a]) + reach for axis in ("r", "q"))
    near = (down >= 0) & (down <= 2 * reach) & (right >= 0) & (right <= 2 * reach)
    bits = np.unpackbits(los[airborne * cells.size + a], axis=1, bitorder="little")
    return near & (bits[np.where(near, down, 0), np.where(near, right, 0)] == 1)


@kernel
def sample_step(dq: int, dr: int, i: int, up: int) -> tuple[int, int]:
    """Cell i of the line to offset (dq, dr), as an offset; ties rounded up or down.

    Along its longest coordinate the line advances by whole cells, so only one of the other two
    has to be rounded; the last follows from q + r + s = 0.
    """
    ds = -dq - dr
    n = max(abs(dq), abs(dr), abs(ds))
    if abs(dq) == n:
        return dq // n * i, nearest(dr * i, n, up)
    if abs(dr) == n:
        return nearest(dq * i, n, up), dr // n * i
    q = nearest(dq * i, n, up)
    return q, -q - ds // n * i


@kernel
def nearest(a: int, n: int, up: int) -> int:
    """Quotient a / n rounded to the nearest integer, halves up or down."""
    if up:
        return (2 * a + n) // (2 * n)
    return -((n - 2 * a) // (2 * n))


@kernel
def build_los(
    cells: Cells, width: int, height: int, range_cells: int, grade_m: int, air_height_m: int
) -> npt.NDArray[np.uint8]:
    """All lines of sight up to `range_cells`, as bits: for every cell a window of those around it.

    The bit of cells a and b lies where b is as seen from a, in cube coordinates [airborne ends * NC + a, b.r - a.r +
    range_cells, (b.q - a.q + range_cells) // 8]. Symmetric for equal ends; with one airborne end, a is that end.
    """
    side = 2 * range_cells + 1
    los = np.zeros((3 * cells.size, side, (side + 7) // 8), np.uint8)
    grid, top_m = axial_grids(cells, width, height, grade_m)
    eye_m = np.array([0, air_height_m])
    for dr in range(range_cells + 1):
        for dq in range(-range_cells, range_cells - dr + 1):
            if dr > 0 or dq >= 0:
                look_along(los, cells, grid, top_m, dq, dr, grade_m, eye_m)
    return los


@kernel
def axial_grids(
    cells: Cells, width: int, height: int, grade_m: int
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Cell index and height of its top in metres at [r, q + height // 2]; NO_CELL: void."""
    shape = (height, width + height // 2)
    grid = np.full(shape, NO_CELL, np.int32)
    top_m = np.full(shape, VOID_TOP_M, np.int32)
    for c in cell_range(cells.size):
        if cells[c].playable:
            r, q = cells[c].r, cells[c].q + height // 2
            grid[r, q] = c
            top_m[r, q] = cells[c].elev_m + grade_m * cells[c].concealed
    return grid, top_m


@kernel
def look_along(
    los: npt.NDArray[np.uint8], cells: Cells, grid: npt.NDArray[np.int32], top_m: npt.NDArray[np.int32],
    dq: int, dr: int, grade_m: int, eye_m: npt.NDArray[np.int64],
) -> None:  # fmt: skip
    """Set the bits of every pair of cells that lie (dq, dr) apart; eye_m [airborne]."""
    lines = lines_to(dq, dr)
    rows, columns = grid.shape
    for r in range(rows - dr):
        for q in range(max(0, -dq), min(columns, columns - dq)):
            a, b = grid[r, q], grid[r + dr, q + dq]
            if a == NO_CELL or b == NO_CELL:
                continue
            for a_flies in range(2):
                for b_flies in range(2):
                    a_m, b_m = cells[a].elev_m + eye_m[a_flies], cells[b].elev_m + eye_m[b_flies]
                    if not sees_along(top_m, r, q, lines, a_m, b_m, grade_m):
                        continue
                    if a_flies >= b_flies:
                        set_bit(los, (a_flies + b_flies) * cells.size + a, dq, dr)
                    if b_flies >= a_flies:
                        set_bit(los, (a_flies + b_flies) * cells.size + b, -dq, -dr)


@kernel
def lines_to(dq: int, dr: int) -> npt.NDArray[np.int64]:
    """Cells strictly between a cell and offset (dq, dr) [side, i, (q, r)], as offsets."""
    n = max(abs(dq), abs(dr), abs(dq + dr))
    lines = np.zeros((2, max(0, n - 1), 2), np.int64)
    for side in camp_range(2):
        for i in range(1, n):
            lines[side, i - 1] = sample_step(dq, dr, i, side)
    return lines


@kernel
def sees_along(
    top_m: npt.NDArray[np.int32],
    r: int,
    q: int,
    lines: npt.NDArray[np.int64],
    a_m: int,
    b_m: int,
    grade_m: int,
) -> bool:
    """Whether at least one of the two lines from (r, q) stays above the tops between.

    a_m, b_m: heights of the ends; the higher one is raised by one level.
    """
    n = lines.shape[1] + 1
    if a_m > b_m:
        a_m += grade_m
    elif b_m > a_m:
        b_m += grade_m
    for side in camp_range(2):
        clear = True
        for i in range(1, n):
            step = lines[side, i - 1]
            if top_m[r + step[1], q + step[0]] * n > a_m * (n - i) + b_m * i:
                clear = False
                break
        if clear:
            return True
    return False


@kernel
def set_bit(los: npt.NDArray[np.uint8], window: int, dq: int, dr: int) -> None:
    """Mark that the cell of a window sees the cell at an offset."""
    reach = los.shape[1] >> 1
    right = dq + reach
    los[window, dr + reach, right >> 3] |= 1 << (right & 7)


@kernel
def exposures(
    cells: Cells, width: int, height: int, los: Sightlines, range_cells: int
) -> npt.NDArray[np.float32]:
    """Share of the playable cells within `range_cells` that see each cell [NC], 0..1."""
    shares = np.zeros(cells.size, np.float32)
    grid, _ = axial_grids(cells, width, height, 0)
    rows, columns = grid.shape
    for a in cell_range(cells.size):
        near = seen = 0
        if cells[a].playable:
            r, q = cells[a].r, cells[a].q + height // 2
            for dr in range(max(-range_cells, -r), min(range_cells, rows - 1 - r) + 1):
                for dq in range(max(-range_cells, -range_cells - dr), min(range_cells, range_cells - dr) + 1):
                    if 0 <= q + dq < columns and grid[r + dr, q + dq] != NO_CELL and (dq != 0 or dr != 0):
                        near += 1
                        seen += line_of_sight(los, GROUND_GROUND, a, grid[r + dr, q + dq], cells)
        shares[a] = seen / max(near, 1)
    return shares
