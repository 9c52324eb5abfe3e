"""Geometry of the offset grid "odd-r", pointy top (rule book, section 1).

A cell is the index y * width + x. Odd rows are one cell shorter: their last column is void, so
that the mirror map, x -> width - 1 - x (even y) or width - 2 - x (odd y), is a symmetry of the
lattice. Users see a cell as four digits, column then row, counted from 1: "0912" is x = 8, y = 11; on a map with a side
of 100 cells or more as six, "009012".
"""

from __future__ import annotations

import re
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import NO_CELL, Cells
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CampIndex, CellIndex

Ints: TypeAlias = npt.NDArray[np.int64]
Bools: TypeAlias = npt.NDArray[np.bool_]

W, SW, SE, E, NE, NW = range(6)
DIRECTION_NAMES = ("W", "SW", "SE", "E", "NE", "NW")
MIRROR_DIRECTION = (E, SE, SW, W, NW, NE)
NO_DIRECTION = -1
MAX_SIDE_CELLS = 250
MIN_SIDE_CELLS = 3

_STEP_Q = np.array([-1, -1, 0, 1, 1, 0])  # cube coordinates of the six neighbours
_STEP_R = np.array([0, 1, 1, 0, -1, -1])


def name_digits(width: int, height: int) -> int:
    """Digits of the column, and of the row, in the names of a map's cells."""
    return 2 if max(width, height) < 100 else 3


def cell_name(cell: int, width: int, height: int) -> str:
    """Column then row, counted from 1, with two digits each, or three on a large map."""
    y, x = divmod(cell, width)
    digits = name_digits(width, height)
    return f"{x + 1:0{digits}d}{y + 1:0{digits}d}"


def parse_cell(name: str, width: int, height: int) -> CellIndex:
    """The cell that `cell_name` printed.

    Raises:
        ConfigError: not as many digits, or no playable cell of this map.
    """
    digits = name_digits(width, height)
    if not re.fullmatch(f"[0-9]{{{2 * digits}}}", name):
        count, example = ("four", "0912") if digits == 2 else ("six", "009012")
        raise ConfigError(f'cell {name!r}: expected {count} digits, column then row, as in "{example}"')
    x, y = int(name[:digits]) - 1, int(name[digits:]) - 1
    if not (0 <= y < height and 0 <= x < row_cells(y, width)):
        raise ConfigError(f"cell {name!r} is off the map: {_extent(width, height)}")
    return CellIndex(y * width + x)


def row_cells(y: int, width: int) -> int:
    """Playable cells in row y."""
    return width - (y & 1)


def playable_mask(width: int, height: int) -> Bools:
    """True on every cell that is not void [y, x]."""
    mask = np.ones((height, width), dtype=np.bool_)
    mask[1::2, -1] = False
    return mask


def cube_coordinates(width: int, height: int) -> tuple[Ints, Ints]:
    """Coordinates q, r of every cell [NC]; the third is -q - r."""
    y, x = np.divmod(np.arange(width * height), width)
    return x - (y - (y & 1)) // 2, y


def mirror_cells(width: int, height: int) -> Ints:
    """Each cell's image under the mirror map [NC]; a void cell's is itself."""
    y, x = np.divmod(np.arange(width * height), width)
    odd = y & 1
    image = y * width + (width - 1 - odd - x)
    return np.where(odd.astype(bool) & (x == width - 1), y * width + x, image)


def neighbour_cells(width: int, height: int) -> Ints:
    """The six neighbours of every cell [NC, direction]; NO_CELL: off the map or void."""
    q, r = cube_coordinates(width, height)
    to_r = r[:, None] + _STEP_R
    to_x = q[:, None] + _STEP_Q + (to_r - (to_r & 1)) // 2
    on_map = (to_r >= 0) & (to_r < height) & (to_x >= 0) & (to_x < width - (to_r & 1))
    on_map &= playable_mask(width, height).reshape(-1, 1)
    return np.where(on_map, to_r * width + to_x, NO_CELL)


@kernel
def cells_apart(cells: Cells, a: CellIndex, b: CellIndex) -> int:
    """Distance of two cells, in cells."""
    dq = cells[a].q - cells[b].q
    dr = cells[a].r - cells[b].r
    return (abs(dq) + abs(dr) + abs(dq + dr)) // 2


@kernel
def direction_between(cells: Cells, a: CellIndex, b: CellIndex) -> int:
    """Direction 0..5 of the neighbour b of a; NO_DIRECTION if b is no neighbour."""
    for d in range(6):
        if cells[a].neighbour[d] == b:
            return d
    return NO_DIRECTION


@kernel
def frame_cell(cells: Cells, cell: CellIndex, camp: CampIndex) -> CellIndex:
    """A cell between map frame and camp's frame, either way; blue's frame is the mirrored map."""
    if camp != Camp.BLUE or cell == NO_CELL:
        return cell
    return CellIndex(cells[cell].mirror)


@kernel
def frame_direction(direction: int, camp: CampIndex) -> int:
    """A direction between map frame and camp's frame, either way."""
    if camp != Camp.BLUE:
        return direction
    return MIRROR_DIRECTION[direction]


def _extent(width: int, height: int) -> str:
    digits = name_digits(width, height)
    one, columns, fewer, rows = (f"{number:0{digits}d}" for number in (1, width, width - 1, height))
    return f"columns {one}-{columns} ({one}-{fewer} in even rows), rows {one}-{rows}"
