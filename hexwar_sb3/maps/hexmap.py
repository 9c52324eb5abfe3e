"""A map: what lies in every cell (rule book, section 1)."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.geometry import (
    MAX_SIDE_CELLS,
    MIN_SIDE_CELLS,
    Bools,
    cell_name,
    mirror_cells,
    name_digits,
    parse_cell,
    playable_mask,
)
from hexwar_sb3.rules.indices import CellIndex

LAYERS = ("passable", "paved", "concealed", "slushy", "controllable")


@dataclass(frozen=True, eq=False, kw_only=True)
class HexMap:
    """Terrain of every cell; all arrays [y, x], read-only, false and 0 on void cells."""

    name: str
    grade_m: int  # metres of one level of altitude
    elev_m: npt.NDArray[np.int16]  # a multiple of grade_m
    passable: Bools  # ground pieces may enter
    paved: Bools  # road
    concealed: Bools  # forest or built-up
    slushy: Bools  # soft ground, marsh, ford
    controllable: Bools  # may hold a control point
    seed: int | None = None  # of the generator, if it made this map

    def __post_init__(self) -> None:
        """Check what every reader of a map relies on.

        Raises:
            ConfigError: shapes differ, the size is out of range, or an altitude is no multiple.
        """
        sides = range(MIN_SIDE_CELLS, MAX_SIDE_CELLS + 1)
        if self.elev_m.ndim != 2 or self.width not in sides or self.height not in sides:
            raise ConfigError(
                f"map of shape {self.elev_m.shape}; expected two sides of 3 to {MAX_SIDE_CELLS} cells"
            )
        if self.grade_m < 1 or (self.elev_m % self.grade_m).any():
            raise ConfigError(f"an altitude is no multiple of grade_m = {self.grade_m}")
        for layer in LAYERS:
            self._check_layer(layer)
        if self.elev_m[~self.playable].any():
            raise ConfigError("altitude of a void cell (last column of an odd row) must be 0")
        self.elev_m.flags.writeable = False

    def _check_layer(self, layer: str) -> None:
        values: Bools = getattr(self, layer)
        if values.shape != self.elev_m.shape or values.dtype != np.bool_:
            raise ConfigError(f"{layer}: expected booleans of shape {self.elev_m.shape}")
        if (values & ~self.playable).any():
            raise ConfigError(f"{layer} must be false on void cells (last column of odd rows)")
        values.flags.writeable = False

    @property
    def width(self) -> int:
        """Columns; odd rows use one less."""
        return self.elev_m.shape[1]

    @property
    def height(self) -> int:
        """Rows."""
        return self.elev_m.shape[0]

    @property
    def n_cells(self) -> int:
        """Length of every array over cells, void ones included."""
        return self.elev_m.size

    @cached_property
    def playable(self) -> Bools:
        """True on every cell that is not void [y, x]."""
        return playable_mask(self.width, self.height)

    @cached_property
    def hash(self) -> str:
        """Hash of all that matters in play (name and seed do not)."""
        digest = hashlib.sha256(f"{self.width}x{self.height}/{self.grade_m}".encode())
        digest.update(self.elev_m.astype("<i2").tobytes())
        for layer in LAYERS:
            digest.update(getattr(self, layer).tobytes())
        return digest.hexdigest()[:16]

    @property
    def name_length(self) -> int:
        """Digits of a cell's name."""
        return 2 * name_digits(self.width, self.height)

    def cell_name(self, cell: int) -> str:
        """Column then row, counted from 1, in four digits, or six on a large map."""
        return cell_name(cell, self.width, self.height)

    def parse_cell(self, name: str) -> CellIndex:
        """The cell of that name; ConfigError if this map has none."""
        return parse_cell(name, self.width, self.height)

    def mirrored(self) -> HexMap:
        """The same map with west and east exchanged."""
        mirror = mirror_cells(self.width, self.height)

        def turn(layer: str) -> npt.NDArray[np.generic]:
            values: npt.NDArray[np.generic] = getattr(self, layer)
            return values.ravel()[mirror].reshape(values.shape)

        arrays = {layer: turn(layer) for layer in ("elev_m", *LAYERS)}
        return HexMap(name=self.name, grade_m=self.grade_m, seed=self.seed, **arrays)  # type: ignore[arg-type]

    def is_symmetric(self) -> bool:
        """Whether west and east are mirror images, so that neither camp has the better side."""
        return self.mirrored().hash == self.hash
