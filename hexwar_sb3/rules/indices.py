"""Indices that nobody may swap: whole numbers, apart to a type checker.

To kernels they are `int`, and their ranges `range`: `PieceIndex(i)` costs nothing, and says that i is one.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NewType, Protocol, TypeAlias, TypeVar

Index_co = TypeVar("Index_co", covariant=True)

if TYPE_CHECKING:
    from hexwar_sb3.rules.enums import Camp

    CampIndex: TypeAlias = Camp

    PieceIndex = NewType("PieceIndex", int)  # of both camps, red's first
    SlotIndex = NewType("SlotIndex", int)  # of a piece within its camp
    CellIndex = NewType("CellIndex", int)  # of the map's playable cells, row by row
    PointIndex = NewType("PointIndex", int)  # of a control point

    class _Range(Protocol[Index_co]):
        def __call__(self, start: int, stop: int = ..., /) -> Iterator[Index_co]: ...

    piece_range: _Range[PieceIndex]
    camp_range: _Range[CampIndex]
    slot_range: _Range[SlotIndex]
    cell_range: _Range[CellIndex]
    point_range: _Range[PointIndex]
else:
    CampIndex = PieceIndex = SlotIndex = CellIndex = PointIndex = int
    piece_range = camp_range = slot_range = cell_range = point_range = range
