"""Whose turn it is to be led from outside, and walks to random cells: the route env's loops over many games."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_PIECE, PieceRecord
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.play.lower import asks
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.records import ENDED, MissionRecord, TaskKind
from hexwar_sb3.tasks.route import has_way

NO_FOCUS = -1
WANDER_CELLS = 40  # farthest goal of a walk to a random cell


@kernel
def may_go(piece: PieceRecord, mission: MissionRecord) -> bool:
    """The piece will ask for its way, sooner or later."""
    return on_map(piece) and mission.state != ENDED and asks(mission)


@kernel
def take_turns(
    which: NDArray[np.int64],
    first: NDArray[np.int64],
    end: NDArray[np.int64],
    pieces: Rows,
    missions: Rows,
    focus: NDArray[np.int64],
    turn: NDArray[np.int64],
) -> None:
    """Make the next piece that has somewhere to go the focal one, where the focal one has not; else all stays.

    Args:
        which: games [n].
        first: the learner's first piece in each of them [n].
        end: behind the learner's last piece in each of them [n].
        pieces: of all games [B, P].
        missions: of all games [B, P].
        focus: focal piece of every game, changed in place [B].
        turn: slot of the camp that had its turn last, changed in place [B].
    """
    for row in range(which.size):
        b = which[row]
        if focus[b] != NO_FOCUS and may_go(pieces[b, focus[b]], missions[b, focus[b]]):
            continue
        n_own = end[row] - first[row]
        for k in range(1, n_own + 1):
            slot = (turn[b] + k) % n_own
            i = first[row] + slot
            if may_go(pieces[b, i], missions[b, i]):
                focus[b], turn[b] = i, slot
                break


@kernel
def send_away(
    which: NDArray[np.int64],
    own: NDArray[np.int64],
    goals: NDArray[np.int64],
    drops: NDArray[np.bool_],
    games: Rows,
    pieces: Rows,
    missions: Rows,
    rules: Row,
    cells: Rows,
    eta: Rows,
) -> None:
    """Send pieces to cells that they can reach, so that ways lead everywhere, not to few spots.

    Args:
        which: game of each piece [n].
        own: the pieces [n].
        goals: cell of each [n].
        drops: it sets its passenger down instead, if it has one [n].
        games: all of them [B].
        pieces: of all games [B, P].
        missions: of all games, changed in place [B, P].
        rules: of the scenario.
        cells: of the map.
        eta: hops from cell to cell.
    """
    for row in range(which.size):
        b, i = which[row], own[row]
        piece, goal, tick = pieces[b, i], goals[row], games[b].tick
        if not on_map(piece):
            continue
        if piece.passenger != NO_PIECE and drops[row]:
            assign(missions[b, i], TaskKind.DROP, NO_PIECE, piece.cell, tick)
        elif cells_apart(cells, piece.cell, goal) <= WANDER_CELLS and has_way(
            piece.kind, piece.cell, goal, rules, cells, eta
        ):
            assign(missions[b, i], TaskKind.HOLD, NO_PIECE, goal, tick)
