"""Warm start (III-C): a camp's pieces first go to random cells within the hull G^B of the hot spots."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.hotspots import hull_corners, plane
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.spots import SPOTS, load_spots
from hexwar_sb3.tasks.travel import travel_ticks

WARM_TICKS = 400  # longest way of a warm start; a setting, not a rule


@lru_cache(maxsize=16)
def hull_cells(world: World, camp: int, k: int = SPOTS) -> NDArray[np.int64]:
    """G^B: passable cells within the convex hull of the camp's hot spots G^L(k)."""
    corners = hull_corners(world, np.unique(load_spots(world, k)[camp]).tolist())
    x, y = plane(world)
    inside = world.cells.passable == 1
    for a, b in zip(corners, np.roll(corners, -1), strict=True):
        inside &= (x[b] - x[a]) * (y - y[a]) >= (y[b] - y[a]) * (
            x - x[a]
        )  # to the left of the way from a to b
    return np.flatnonzero(inside)


def send_out(
    camp: int, game: Row, pieces: Rows, missions: Rows, world: World, k: int, rng: np.random.Generator
) -> None:
    """Send every piece of a camp to a random cell of the hull that it reaches in time."""
    cells = hull_cells(world, camp, k)
    for i in range(*world.side(camp).indices(world.n_pieces)):
        if not on_map(pieces[i]):
            continue
        ticks = np.zeros(cells.size, np.int64)
        way_ticks(pieces[i], cells, world.rules, world.cells, world.eta, ticks)
        near = cells[ticks <= WARM_TICKS]
        if near.size:
            assign(missions[i], TaskKind.HOLD, NO_PIECE, CellIndex(rng.choice(near)), game.tick)


@kernel
def way_ticks(piece: Row, goals: Rows, rules_array: Rows, cells: Rows, eta: Rows, ticks: Rows) -> None:
    """Write the travel time from the piece's cell to each of the goals [n]."""
    for k in range(goals.size):
        ticks[k] = travel_ticks(piece.kind, piece.cell, goals[k], rules_array[0], cells, eta)
