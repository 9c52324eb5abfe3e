"""Random legal orders: play that reaches every corner of the rules, for tests and measurements."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.dice import splitmix64
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.records import (
    NO_CELL,
    GameRecord,
    OrderRecord,
    Orders,
    PieceRecord,
    Pieces,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import DIRECTION_NAMES, cells_apart
from hexwar_sb3.rules.compiled import NO_POOL, RulesRecord
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range

_N_DIRECTIONS = len(DIRECTION_NAMES)
_NUMBERS = 32  # of which a piece is drawn: some are of none
_TRIES = 32  # candidates for a piece before it does nothing; the first half of them tries to act
_DRAWS = 16  # random numbers of one candidate
_LONGEST_PATH = 6
_CHASES = 2 * _N_DIRECTIONS  # half of the paths lead towards a piece
_STOPS = 4  # one stop order in so many is given
_TOP_BITS = np.uint64(33)  # leaves 31 bits: a whole number in any integer type
_ACTS = (
    Action.SHOOT,
    Action.GUIDE_SHOOT,
    Action.GUIDE_SHOOT,
    Action.GET_ON,
    Action.GET_OFF,
    Action.OCCUPY,
    Action.DECOMPRESS,
    Action.INDIRECT_SHOOT,
)
_MOVES = (Action.MOVE, Action.MOVE, Action.STOP, Action.HIDE, *(Action.NULL,) * 12)


@kernel
def draw(seed: np.uint64, tick: int, i: PieceIndex, n: int, below: int) -> int:
    """Random whole number n of piece i in this tick, from 0 to below - 1."""
    x = splitmix64(np.uint64(seed) ^ splitmix64(np.uint64((int(tick) * 64 + int(i)) * 4096 + int(n))))
    return int(x >> _TOP_BITS) % below


@kernel
def random_orders(
    seed: np.uint64, game: GameRecord, pieces: Pieces, orders: Orders, rules: RulesRecord, cells: Cells
) -> None:
    """Give the pieces of both camps random legal orders; the same seed and state give the same."""
    for i in piece_range(pieces.size):
        order = orders[i]
        for n in range(_TRIES):
            propose(seed, i, n, order, game, pieces, rules, cells)
            if order_code(i, order, game, pieces, rules, cells) == Code.OK:
                break
            order.kind = int(Action.NULL)


@kernel
def propose(
    seed: np.uint64,
    i: PieceIndex,
    n: int,
    order: OrderRecord,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """Write the nth random order for piece i, legal or not."""
    tick, n0 = game.tick, n * _DRAWS
    if n * 2 < _TRIES:
        order.kind = int(_ACTS[draw(seed, tick, i, n0, len(_ACTS))])
    else:
        order.kind = int(_MOVES[draw(seed, tick, i, n0, len(_MOVES))])
    order.weapon = carried(pieces[i], draw(seed, tick, i, n0 + 1, rules.pool.shape[1]), rules)
    boards = order.kind == Action.GET_ON or order.kind == Action.GET_OFF
    order.target = any_of(
        pieces[i].camp if boards else CampIndex(1 - pieces[i].camp),
        draw(seed, tick, i, n0 + 2, _NUMBERS),
        game,
    )
    order.partner = any_of(pieces[i].camp, draw(seed, tick, i, n0 + 3, _NUMBERS), game)
    order.cell = CellIndex(draw(seed, tick, i, n0 + 4, cells.size))
    order.path_len = 1 + draw(seed, tick, i, n0 + 5, _LONGEST_PATH)
    walk(order, pieces[i].cell, pieces[order.target].cell, draw(seed, tick, i, n0 + 6, _CHASES), cells)
    if order.kind == Action.STOP and draw(seed, tick, i, n0 + 7, _STOPS) > 0:
        order.kind = int(Action.NULL)


@kernel
def any_of(camp: CampIndex, number: int, game: GameRecord) -> PieceIndex:
    """A piece of the camp by any number."""
    if camp == Camp.RED:
        return PieceIndex(number % game.n_red)
    return PieceIndex(game.n_red + number % (game.n_pieces - game.n_red))


@kernel
def walk(order: OrderRecord, cell: CellIndex, goal: CellIndex, way: int, cells: Cells) -> None:
    """Write a path: straight in direction `way`, or towards the goal if that is no direction."""
    for k in range(order.path_len):
        direction = way if way < _N_DIRECTIONS else toward(cell, goal, cells)
        order.path[k] = direction
        if cells[cell].neighbour[direction] != NO_CELL:
            cell = cells[cell].neighbour[direction]


@kernel
def toward(cell: CellIndex, goal: CellIndex, cells: Cells) -> int:
    """Direction of the neighbour that is nearest to the goal."""
    best = 0
    apart = cells.size
    for d in range(_N_DIRECTIONS):
        beside = cells[cell].neighbour[d]
        if beside != NO_CELL and cells_apart(cells, beside, goal) < apart:
            best, apart = d, cells_apart(cells, beside, goal)
    return best


@kernel
def carried(piece: PieceRecord, weapon: int, rules: RulesRecord) -> int:
    """The first weapon from this one on, around the table, that the piece carries."""
    n = rules.pool.shape[1]
    for k in range(n):
        if rules.pool[piece.kind, (weapon + k) % n] != NO_POOL:
            return (weapon + k) % n
    return weapon
