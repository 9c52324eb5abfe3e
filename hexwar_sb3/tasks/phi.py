"""From a task and an answer of the lower level to an order: phi, eq. (2)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import occupy_code, order_code
from hexwar_sb3.engine.pieces import has_path, hop_progress, in_fight, stands_in
from hexwar_sb3.engine.records import (
    NO_CELL,
    NO_PIECE,
    ROUND_FLYING,
    GameRecord,
    Memory,
    Orders,
    PieceRecord,
    Pieces,
    Rounds,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece, known_in_zone
from hexwar_sb3.tasks.records import Missions, TaskKind


@kernel
def give(
    i: PieceIndex,
    kind: int,
    target: PieceIndex,
    cell: CellIndex,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """Write an order if it is legal now; False, and no order, if it is not.

    Args:
        target: carrier to board or passenger to set down, else NO_PIECE.
        cell: where to lob a round, else NO_CELL.
    """
    order = orders[i]
    order.kind = kind
    order.target = target
    order.cell = cell
    return keep_if_legal(i, game, pieces, orders, rules, cells)


@kernel
def keep_if_legal(
    i: PieceIndex, game: GameRecord, pieces: Pieces, orders: Orders, rules: RulesRecord, cells: Cells
) -> bool:
    """Take an illegal order back."""
    if order_code(i, orders[i], game, pieces, rules, cells) == Code.OK:
        return True
    orders[i].kind = Action.NULL
    return False


@kernel
def give_move(
    i: PieceIndex,
    direction: int,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """One hop in a direction, if it is legal now."""
    orders[i].kind = Action.MOVE
    orders[i].path_len = 1
    orders[i].path[0] = direction
    return keep_if_legal(i, game, pieces, orders, rules, cells)


@kernel
def give_shot(
    i: PieceIndex,
    target: PieceIndex,
    weapon: int,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """A direct shot, if it is legal now."""
    orders[i].weapon = weapon
    return give(i, Action.SHOOT, target, NO_CELL, game, pieces, orders, rules, cells)


@kernel
def give_guided(
    i: PieceIndex,
    target: PieceIndex,
    chariot: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """A guided shot, if it is legal now."""
    orders[i].partner = chariot
    return give(i, Action.GUIDE_SHOOT, target, NO_CELL, game, pieces, orders, rules, cells)


@kernel
def may_turn_back(piece: PieceRecord, tick: int) -> bool:
    """A stop would make the piece stand in its cell: it waits, or is in the first half of a hop."""
    if not has_path(piece) or piece.stop_pending == 1:
        return False
    return piece.waiting == 1 or 2 * hop_progress(piece, tick) < piece.hop_need


@kernel
def may_occupy(i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, cells: Cells) -> bool:
    """Piece i stands on a control point that it can take: no enemy is seen there or beside it."""
    piece = pieces[i]
    if occupy_code(piece, game) != Code.OK:
        return False
    return known_in_zone(piece.camp, piece.cell, game, pieces, memory, cells) == 0


@kernel
def has_flying_round(i: PieceIndex, rounds: Rounds) -> bool:
    """A mortar round of piece i is in the air; a move would lose it."""
    for r in range(rounds.size):
        if rounds[r].owner == i and rounds[r].status == ROUND_FLYING:
            return True
    return False


@kernel
def is_own_in(camp: CampIndex, cell: CellIndex, game: GameRecord, pieces: Pieces) -> bool:
    """An own ground piece stands in a cell."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if stands_in(pieces[i], cell):
            return True
    return False


@kernel
def task_action(
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    orders: Orders,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """The action of piece i's task, ordered if it is legal now and the piece is at its place.

    Direct and guided shots are not here: they come from `execute`, which sees all shooters.
    """
    piece = pieces[i]
    mission = missions[i]
    kind = mission.kind
    at_place = mission.cell == NO_CELL or mission.cell == piece.cell
    if (kind == TaskKind.HIDE or kind == TaskKind.SHADOW) and at_place:
        return give(i, Action.HIDE, NO_PIECE, NO_CELL, game, pieces, orders, rules, cells)
    if kind == TaskKind.DROP and at_place:
        return give(i, Action.GET_OFF, piece.passenger, NO_CELL, game, pieces, orders, rules, cells)
    if kind == TaskKind.BOMBARD:
        cell = memory[piece.camp, mission.target].cell
        if is_own_in(piece.camp, cell, game, pieces):
            return False
        return give(i, Action.INDIRECT_SHOOT, NO_PIECE, cell, game, pieces, orders, rules, cells)
    if kind == TaskKind.BOARD and not in_fight(game, piece):
        return give(i, Action.GET_ON, mission.target, NO_CELL, game, pieces, orders, rules, cells)
    if kind == TaskKind.RECOVER:
        return give(i, Action.DECOMPRESS, NO_PIECE, NO_CELL, game, pieces, orders, rules, cells)
    if kind == TaskKind.STOP and may_turn_back(piece, game.tick):
        return give(i, Action.STOP, NO_PIECE, NO_CELL, game, pieces, orders, rules, cells)
    return False


@kernel
def phi(
    i: PieceIndex, answer: int, game: GameRecord, pieces: Pieces, memory: Memory, orders: Orders, missions: Missions, rules: RulesRecord,
    cells: Cells,
) -> bool:  # fmt: skip
    """Order for a task and an answer, eq. (2): the task's action for 0, else one hop in direction answer - 1.

    Returns:
        Whether an order was given; what is not legal now is asked for again at the next event.
    """
    if answer == 0:
        return task_action(i, game, pieces, memory, orders, missions, rules, cells)
    return give_move(i, answer - 1, game, pieces, orders, rules, cells)
