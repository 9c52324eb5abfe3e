"""What kernels read of a map: cells and lines of sight.

The tables take a second to build, so they are kept as files in the cache folder, mapped into memory and shared by all
processes. A file's name is the hash of everything it depends on; one of another shape, type or content is made anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from hexwar_sb3.cache import cache
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps import cells, geometry, sightlines, travel
from hexwar_sb3.maps.hexmap import LAYERS, HexMap
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.rules.ruleset import RuleSet

Table: TypeAlias = npt.NDArray[Any]

EXPOSURE_CELLS = 15  # how far around a cell its exposure is counted
_AIRBORNE_ENDS = 3  # of a line: none, one, both
_WORTH_FILING_BYTES = 100_000  # smaller tables are built faster than they are read
_RULES = (
    *("base_hop", "max_climb", "steep_m", "steep_factor", "slushy_factor", "concealed_factor"),
    *("sight", "observer_cells", "air_height_m"),
)
_SOURCES = (__file__, cells.__file__, geometry.__file__, sightlines.__file__, travel.__file__)


class Terrain:
    """One map under one rule set, compiled; every table is built or loaded when first asked for."""

    def __init__(self, hexmap: HexMap, ruleset: RuleSet) -> None:
        self.hexmap, self.ruleset = hexmap, ruleset
        self.rules = ruleset.compiled()[0]

    def __reduce__(self) -> tuple[type[Terrain], tuple[HexMap, RuleSet]]:
        return type(self), (self.hexmap, self.ruleset)  # the tables are found where it arrives

    def __copy__(self) -> Terrain:
        return self  # nothing in it ever changes

    def __deepcopy__(self, memo: dict[int, object]) -> Terrain:
        return self

    @cached_property
    def hash(self) -> str:
        """Hash of the map, the rules and the source code that the tables come from."""
        numbers = [self.rules[name].tolist() for name in _RULES]
        digest = hashlib.sha256(f"{self.hexmap.hash}/{numbers}".encode())
        for source in _SOURCES:
            digest.update(Path(source).read_bytes())
        return digest.hexdigest()[:16]

    @cached_property
    def cells(self) -> Rows:
        """Records CELL [NC], read-only."""
        shape = (self.hexmap.n_cells,)
        return _kept(f"{self.hash}-cells", cells.CELL, shape, self._build_cells).view(np.recarray)

    @cached_property
    def los(self) -> Any:
        """Lines of sight within the longest range, as windows of bits (`build_los`), read-only."""
        side = 2 * self._range_cells + 1
        shape = (_AIRBORNE_ENDS * self.hexmap.n_cells, side, -(-side // 8))
        return _kept(
            f"{self.hash}-los", np.dtype(np.uint8), shape, lambda: self._build_los(self._bare_cells())
        )

    def times_to(self, hop_class: int, target: int) -> npt.NDArray[np.uint8]:
        """Fastest travel times from every cell to one, base hops [NC]."""
        return travel.travel_times(hop_class, CellIndex(target), False, self.rules, self.cells)

    def times_from(self, hop_class: int, start: int) -> npt.NDArray[np.uint8]:
        """Fastest travel times from one cell to every other, base hops [NC]."""
        return travel.travel_times(hop_class, CellIndex(start), True, self.rules, self.cells)

    def _bare_cells(self) -> Rows:
        """Cells without exposure, which needs the lines of sight."""
        hexmap = self.hexmap
        rows = np.zeros(hexmap.n_cells, cells.CELL).view(np.recarray)
        rows.neighbour = geometry.neighbour_cells(hexmap.width, hexmap.height)
        rows.hop_ticks = travel.hop_ticks(hexmap, self.rules)
        rows.mirror = geometry.mirror_cells(hexmap.width, hexmap.height)
        rows.y, rows.x = np.divmod(np.arange(hexmap.n_cells), hexmap.width)
        rows.q, rows.r = geometry.cube_coordinates(hexmap.width, hexmap.height)
        rows.elev_m = hexmap.elev_m.ravel()
        rows.level = rows.elev_m // hexmap.grade_m
        for layer in ("playable", *LAYERS):
            rows[layer] = getattr(hexmap, layer).ravel()
        return rows

    def _build_cells(self) -> Rows:
        rows = self._bare_cells()
        width, height = self.hexmap.width, self.hexmap.height
        rows.exposure = sightlines.exposures(rows, width, height, self.los, EXPOSURE_CELLS)
        return rows

    def _build_los(self, rows: Rows) -> npt.NDArray[np.uint8]:
        width, height, grade_m = self.hexmap.width, self.hexmap.height, self.hexmap.grade_m
        air_height_m = int(self.rules.air_height_m)
        return sightlines.build_los(rows, width, height, self._range_cells, grade_m, air_height_m)

    @property
    def _range_cells(self) -> int:
        return max(int(self.rules.sight.max()), int(self.rules.observer_cells))


def _kept(name: str, dtype: np.dtype[Any], shape: tuple[int, ...], build: Callable[[], Table]) -> Table:
    """The table from its file, or built and filed; in memory if it is small or nothing can be kept."""
    size = prod(shape) * dtype.itemsize
    if size < _WORTH_FILING_BYTES:
        return _read_only(build())
    what = f"{dtype.descr} {shape}"
    kept = cache().map("terrain", f"{name}.table", what, size)
    if kept is None:
        table = _read_only(build())
        if not cache().keep("terrain", f"{name}.table", table.reshape(-1).view(np.uint8).data, what):
            return table
        kept = cache().map("terrain", f"{name}.table", what, size)
    return table if kept is None else np.frombuffer(kept, dtype).reshape(shape)


def _read_only(table: Table) -> Table:
    table.flags.writeable = False
    return np.asarray(table)
