"""Building blocks of the generator: fields, patches and ways, alike west and east or each by itself.

A field is an array [y, x] over all cells. Of a map that is alike only the western half is ever drawn; the eastern half
is its image under the mirror map, so that symmetry is exact whatever the arithmetic.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.cells import NO_CELL
from hexwar_sb3.maps.geometry import (
    Bools,
    Ints,
    cube_coordinates,
    mirror_cells,
    neighbour_cells,
    playable_mask,
    row_cells,
)

Field: TypeAlias = npt.NDArray[np.float64]
Kind = TypeVar("Kind", bound=np.generic)

NEVER_HERE = np.inf  # cost of a cell that no way may use
_WAVES = 24  # cosines in one noise field


@dataclass(frozen=True)
class Canvas:
    """A grid to draw a map on, with its own random numbers."""

    width: int
    height: int
    rng: np.random.Generator
    alike: bool = True  # east is the mirror image of west

    @cached_property
    def mirror(self) -> Ints:
        """Each cell's mirror image [NC]."""
        return mirror_cells(self.width, self.height)

    @cached_property
    def neighbours(self) -> Ints:
        """The neighbours of every cell [NC, 6]."""
        return neighbour_cells(self.width, self.height)

    @cached_property
    def playable(self) -> Bools:
        """True on every cell that is not void [y, x]."""
        return playable_mask(self.width, self.height)

    @cached_property
    def east(self) -> Field:
        """Distance east of the axis, in cells [y, x]."""
        x = np.arange(self.width) + (np.arange(self.height) & 1)[:, None] / 2
        return x - (self.width - 1) / 2

    @cached_property
    def south(self) -> Field:
        """Distance south of the northern edge, in cells [y, x]."""
        rows = np.arange(self.height) * np.sqrt(3) / 2
        return np.repeat(rows[:, None], self.width, axis=1)

    def cell(self, x: int, y: int) -> int:
        """Index of a cell, of the nearest one if that is off the map."""
        row = min(max(y, 0), self.height - 1)
        return row * self.width + min(max(x, 0), row_cells(row, self.width) - 1)

    def beside(self, cell: int, reach: int = 3) -> int:
        """A random cell within some columns and rows of another."""
        y, x = divmod(cell, self.width)
        dx, dy = self.rng.integers(-reach, reach + 1, 2).tolist()
        return self.cell(x + dx, y + dy)

    def fold(self, field: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """The western half of a field, and its mirror image in the east; the field itself where they are not alike."""
        if not self.alike:
            return field
        image = field.ravel()[self.mirror].reshape(field.shape)
        folded: npt.NDArray[Kind] = np.where(self.east <= 0, field, image)
        return folded

    def marks(self, cells: list[int]) -> Bools:
        """Marks on some cells, and their images where west and east are alike [y, x]."""
        marks = np.zeros((self.height, self.width), np.bool_)
        marks.flat[cells] = True
        return self.symmetric(marks)

    def symmetric(self, marks: Bools) -> Bools:
        """Marks, and their images where west and east are alike [y, x]."""
        return marks | self.image(marks) if self.alike else marks

    def image(self, marks: Bools) -> Bools:
        """The mirror image of marks [y, x]."""
        return np.asarray(marks.ravel()[self.mirror].reshape(marks.shape))

    def noise(self, wavelength_cells: float) -> Field:
        """A smooth random field of mean 0 and variance about 1, alike west and east or not [y, x]."""
        angle = self.rng.uniform(0, np.pi, _WAVES)
        pulse = 2 * np.pi / (wavelength_cells * self.rng.uniform(0.75, 1.5, _WAVES))
        phase = self.rng.uniform(0, 2 * np.pi, _WAVES)
        total = np.zeros(self.east.shape)
        for east in (self.east, -self.east) if self.alike else (self.east,):
            path = east[..., None] * np.cos(angle) + self.south[..., None] * np.sin(angle)
            total += np.cos(path * pulse + phase).sum(axis=-1)
        return self.fold(total / np.sqrt(_WAVES if self.alike else _WAVES / 2))

    def parcels(self, size_cells: float, field: Field) -> tuple[Field, Bools]:
        """The plane cut into parcels: the field's mean over each, and the edges between them."""
        rows, columns = (int(extent / size_cells) + 2 for extent in (self.height, self.width))
        grid = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"), axis=-1)
        seeds = (grid + self.rng.uniform(-0.35, 0.35, grid.shape)).reshape(-1, 2) * size_cells
        seeds[:, 1] -= self.width / 2
        away = (self.south[..., None] - seeds[:, 0]) ** 2 + (self.east[..., None] - seeds[:, 1]) ** 2
        parcel = self.fold(away.argmin(axis=-1)).astype(np.int64).ravel()
        total = np.bincount(parcel, field.ravel()) / np.maximum(1, np.bincount(parcel))
        other = (self.neighbours != NO_CELL) & (parcel[self.neighbours] > parcel[:, None])
        shape = field.shape
        return total[parcel].reshape(shape), self.fold(other.any(axis=1).reshape(shape)).astype(bool)

    def distance(self, marks: Bools) -> Field:
        """Cells from each cell to the nearest marked one [y, x]; infinite if none is marked."""
        apart = np.where(marks.ravel(), 0.0, np.inf)
        padded = np.append(apart, np.inf)  # NO_CELL reads the last entry
        while True:
            nearer = np.minimum(padded[:-1], padded[self.neighbours].min(axis=1) + 1)
            if (nearer == padded[:-1]).all():
                return nearer.reshape(marks.shape)
            padded[:-1] = nearer

    def is_whole(self, marks: Bools) -> bool:
        """Whether all marked cells hang together."""
        inside = np.append(marks.ravel(), False)  # NO_CELL reads the last entry
        reached = np.zeros_like(inside)
        reached[int(inside.argmax())] = True
        edge = np.flatnonzero(reached)
        while edge.size:
            near = np.unique(self.neighbours[edge])
            edge = near[inside[near] & ~reached[near] & (near != NO_CELL)]
            reached[edge] = True
        return bool(reached.sum() == inside.sum())

    def disc(self, cell: int, radius: int) -> Bools:
        """The cells within `radius` of a cell [y, x]."""
        return self.hexagon(cell, (radius, radius, radius))

    def nearest(self, cell: int, marks: Bools) -> int:
        """The marked cell nearest to a cell; the first of several."""
        away = np.hypot(self.east - self.east.flat[cell], self.south - self.south.flat[cell])
        return int(np.where(marks, away, np.inf).argmin())

    def hexagon(self, cell: int, reach: tuple[int, int, int]) -> Bools:
        """A convex patch around a cell: within `reach` of it in each cube coordinate [y, x]."""
        q, r = cube_coordinates(self.width, self.height)
        dq, dr = q - q[cell], r - r[cell]
        inside = (abs(dq) <= reach[0]) & (abs(dr) <= reach[1]) & (abs(dq + dr) <= reach[2])
        return inside.reshape(self.playable.shape) & self.playable

    def way(self, start: int, goal: int, cost: Field) -> list[int]:
        """The cheapest way between two cells; cost [y, x] is paid on entering a cell.

        Raises:
            ConfigError: there is no way.
        """
        entering = cost.ravel()
        best, came_from, heap = {start: 0.0}, {start: start}, [(0.0, start)]
        while heap:
            paid, cell = heapq.heappop(heap)
            if cell == goal:
                return _trace(came_from, goal)
            if paid > best[cell]:
                continue
            for neighbour in self.neighbours[cell].tolist():
                if neighbour == NO_CELL or entering[neighbour] == NEVER_HERE:
                    continue
                total = paid + float(entering[neighbour])
                if total < best.get(neighbour, np.inf):
                    best[neighbour], came_from[neighbour] = total, cell
                    heapq.heappush(heap, (total, neighbour))
        raise ConfigError(f"no way from cell {start} to cell {goal}")

    def way_through(self, stops: list[int], cost: Field) -> list[int]:
        """The cheapest way from stop to stop."""
        cells = stops[:1]
        for start, goal in pairwise(stops):
            cells += self.way(start, goal, cost)[1:]
        return cells


def highest(score: Field, allowed: Bools, count: int) -> Bools:
    """The `count` allowed cells of highest score, and those that tie with the last [y, x]."""
    if count <= 0 or not allowed.any():
        return np.zeros(score.shape, np.bool_)
    scores = np.sort(score[allowed])
    return allowed & (score >= scores[-min(count, scores.size)])


def _trace(came_from: dict[int, int], goal: int) -> list[int]:
    cells = [goal]
    while came_from[cells[-1]] != cells[-1]:
        cells.append(came_from[cells[-1]])
    return cells[::-1]
