"""Warm start (III-C): a camp's pieces first go to random cells within the hull G^B of the hot spots."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.spots import load_spots
from hexwar_sb3.tasks.travel import travel_ticks

WARM_TICKS = 400  # longest way of a warm start; a setting, not a rule
_ROW_HEIGHT = np.sqrt(3) / 2  # of rows of hexagons one unit wide


@lru_cache(maxsize=16)
def hull_cells(world: World, camp: int) -> NDArray[np.int64]:
    """G^B: passable cells within the convex hull of the camp's hot spots."""
    corners = _hull(_centres(world)[np.unique(load_spots(world)[camp])])
    centres = _centres(world)
    inside = world.cells.passable == 1
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= _turn(a, b, centres) >= -1e-9
    return np.flatnonzero(inside)


def send_out(camp: int, game: Row, pieces: Rows, plans: Rows, world: World, rng: np.random.Generator) -> None:
    """Send every piece of a camp to a random cell of the hull that it reaches in time."""
    cells = hull_cells(world, camp)
    for i in range(*world.side(camp).indices(world.n_pieces)):
        if not on_map(pieces[i]):
            continue
        ticks = np.zeros(cells.size, np.int64)
        way_ticks(pieces[i], cells, world.rules, world.cells, world.eta, ticks)
        near = cells[ticks <= WARM_TICKS]
        if near.size:
            assign(plans[i], TaskKind.HOLD, NO_PIECE, int(rng.choice(near)), game.tick)


@kernel
def way_ticks(piece: Row, goals: Rows, rules_array: Rows, cells: Rows, eta: Rows, ticks: Rows) -> None:
    """Write the travel time from the piece's cell to each of the goals [n]."""
    for k in range(goals.size):
        ticks[k] = travel_ticks(piece.kind, piece.cell, goals[k], rules_array[0], cells, eta)


def _centres(world: World) -> NDArray[np.float64]:
    """Middle of every cell, in cell widths [NC, 2]."""
    cells = world.cells
    return np.stack([cells.x + 0.5 * (cells.y % 2), cells.y * _ROW_HEIGHT], axis=-1)


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Positive where p lies to the left of the way from a to b."""
    ahead, aside = b - a, p - a
    turn: NDArray[np.float64] = ahead[0] * aside[..., 1] - ahead[1] * aside[..., 0]
    return turn


def _hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    points = points[np.lexsort((points[:, 1], points[:, 0]))]
    return np.array(_chain(points)[:-1] + _chain(points[::-1])[:-1])


def _chain(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    chain: list[NDArray[np.float64]] = []
    for point in points:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0:
            chain.pop()
        chain.append(point)
    return chain
