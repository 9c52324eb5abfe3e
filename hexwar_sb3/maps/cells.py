"""One record a cell: what kernels read of a map."""

from __future__ import annotations

from typing import TypeAlias

from hexwar_sb3.records import F4, I2, I4, U1, Block, Table, Vector, dtype_of, of_shape
from hexwar_sb3.rules.indices import CellIndex

NO_HOP = 0  # hop_ticks: no way there
NO_CELL = CellIndex(-1)  # off the map or void


class CellRecord:
    """What kernels read of a cell."""

    neighbour: Vector[int, I4[CellIndex]] = of_shape(6)  # W SW SE E NE NW; NO_CELL (-1): off the map or void
    hop_ticks: Table[int, int, I2[int]] = of_shape(2, 6)  # [HopClass, direction]; NO_HOP: none
    mirror: I4[CellIndex]  # the mirror map of section 1
    x: I2[int]
    y: I2[int]
    q: I2[int]  # cube coordinates
    r: I2[int]
    elev_m: I2[int]
    level: I2[int]  # elev_m / grade
    exposure: F4[float]  # share of the playable cells within 15 that see it, 0..1
    playable: U1[int]
    controllable: U1[int]
    passable: U1[int]
    paved: U1[int]
    concealed: U1[int]
    slushy: U1[int]


CELL = dtype_of(CellRecord)
Cells: TypeAlias = Vector[CellIndex, CellRecord]
Sightlines: TypeAlias = Block[
    int
]  # [airborne ends * NC + cell, row of its window, column // 8] bits (sightlines.py)

TravelTimes: TypeAlias = Table[int, int, int]  # rows of base hops, and which there are (travel.py)
