"""What kernels read of a map: cells, lines of sight, travel times.

The two big tables take seconds to build and tens of megabytes to hold, so they are kept as
files in the cache folder, mapped into memory and shared by all processes. A file's name is the
hash of everything it depends on; it is written under another name and then renamed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from hexwar_sb3.files import replacing
from hexwar_sb3.kernels import Rows, cache_root
from hexwar_sb3.maps import cells, geometry, sightlines, travel
from hexwar_sb3.maps.hexmap import LAYERS, HexMap
from hexwar_sb3.rules.ruleset import RuleSet

Table: TypeAlias = npt.NDArray[Any]

EXPOSURE_CELLS = 15  # how far around a cell its exposure is counted
_WORTH_FILING_BYTES = 100_000  # smaller tables are built faster than they are read
_RULES = (
    *("base_hop", "max_climb", "steep_m", "steep_factor", "slushy_factor", "concealed_factor"),
    *("sight", "observer_cells", "air_height_m"),
)
_SOURCES = (__file__, cells.__file__, geometry.__file__, sightlines.__file__, travel.__file__)


class Terrain:
    """One map under one rule set, compiled; every table is built or loaded when first asked for."""

    def __init__(self, hexmap: HexMap, ruleset: RuleSet) -> None:
        self.hexmap = hexmap
        self.rules = ruleset.compiled()[0]

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
        return _kept(f"{self.hash}-cells", self._build_cells).view(np.recarray)

    @cached_property
    def los(self) -> npt.NDArray[np.uint8]:
        """Lines of sight within the longest range, as bits [airborne ends, a, b // 8], read-only."""
        return _kept(f"{self.hash}-los", lambda: self._build_los(self._bare_cells()))

    @cached_property
    def eta(self) -> npt.NDArray[np.uint8]:
        """Fastest travel times in base hops [HopClass, target, cell], read-only."""
        return _kept(f"{self.hash}-eta", self._build_eta)

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
        rows.exposure = sightlines.exposures(rows, self.los, EXPOSURE_CELLS)
        return rows

    def _build_los(self, rows: Rows) -> npt.NDArray[np.uint8]:
        range_cells = max(int(self.rules.sight.max()), int(self.rules.observer_cells))
        width, height, grade_m = self.hexmap.width, self.hexmap.height, self.hexmap.grade_m
        air_height_m = int(self.rules.air_height_m)
        return sightlines.build_los(rows, width, height, range_cells, grade_m, air_height_m)

    def _build_eta(self) -> npt.NDArray[np.uint8]:
        return travel.travel_times(self._bare_cells(), travel.base_hops(self.rules))


def _kept(name: str, build: Callable[[], Table]) -> Table:
    """The table from its file, or built and filed; in memory if small or the folder is not writable."""
    path = cache_root() / "terrain" / f"{name}.npy"
    try:
        return np.asarray(np.load(path, mmap_mode="r"))
    except (OSError, ValueError, EOFError):  # none yet, or damaged
        table = build()
    table.flags.writeable = False
    if table.nbytes < _WORTH_FILING_BYTES:
        return table
    try:
        with replacing(path) as temporary:
            np.save(temporary, np.asarray(table), allow_pickle=False)
        return np.asarray(np.load(path, mmap_mode="r"))
    except (OSError, ValueError, EOFError):  # full or read-only disk
        return table
