"""The orders of one step: judged, fired, started (rule book, sections 4 and 5)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.dice import priority
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.legality import order_code, point_at
from hexwar_sb3.engine.mortar import launch
from hexwar_sb3.engine.movement import begin_move, begin_stop
from hexwar_sb3.engine.pieces import count_in, spend_round
from hexwar_sb3.engine.records import (
    BOARD_OFF,
    BOARD_ON,
    NEVER,
    NO_CELL,
    NO_PIECE,
    GameRecord,
    Log,
    OrderRecord,
    Orders,
    Paths,
    PieceRecord,
    Pieces,
    Rounds,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, Weapon
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, piece_range


@kernel
def judge_orders(
    game: GameRecord, pieces: Pieces, orders: Orders, log: Log, rules: RulesRecord, cells: Cells
) -> None:
    """Write the code of every order: first each alone, then against the own camp's other orders."""
    for i in piece_range(orders.size):
        orders[i].code = int(order_code(i, orders[i], game, pieces, rules, cells))
    for i in piece_range(orders.size):
        if orders[i].code == Code.OK and needs_partner(orders[i]):
            orders[i].code = int(partner_code(i, game, pieces, orders))
    for i in piece_range(orders.size):
        if orders[i].code != Code.OK:
            note(game, log, Event.REFUSED, i, NO_PIECE, pieces[i].cell, orders[i].code)


@kernel
def needs_partner(order: OrderRecord) -> bool:
    """Does the order lay hands on another own piece?"""
    return order.kind == Action.GUIDE_SHOOT or order.kind == Action.GET_ON


@kernel
def partner_of(order: OrderRecord) -> PieceIndex:
    """The chariot that an order of guiding or boarding claims."""
    return order.partner if order.kind == Action.GUIDE_SHOOT else order.target


@kernel
def partner_code(i: PieceIndex, game: GameRecord, pieces: Pieces, orders: Orders) -> int:
    """The claimed chariot must have no order of its own, and no rival of better priority."""
    chariot = partner_of(orders[i])
    if orders[chariot].kind != Action.NULL and orders[chariot].code == Code.OK:
        return Code.PARTNER_BUSY
    for j in piece_range(orders.size):
        rival = j != i and orders[j].kind == orders[i].kind and partner_of(orders[j]) == chariot
        if not rival or (orders[j].code != Code.OK and orders[j].code != Code.CONFLICT):
            continue
        if priority(game, game.tick, pieces[j]) < priority(game, game.tick, pieces[i]):
            return Code.CONFLICT
    return Code.OK


@kernel
def start_orders(
    game: GameRecord,
    pieces: Pieces,
    paths: Paths,
    rounds: Rounds,
    orders: Orders,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """Begin what the legal orders say, and pay for the shots; occupy comes after the fire."""
    for i in piece_range(orders.size):
        order = orders[i]
        piece = pieces[i]
        if order.code == Code.OK:
            if order.kind == Action.MOVE:
                begin_move(i, order, pieces, paths)
            elif order.kind == Action.STOP:
                begin_stop(piece, game.tick, rules)
            elif order.kind == Action.HIDE:
                piece.hide_ends = game.tick + rules.hide_ticks
            elif order.kind == Action.SHOOT:
                pay_shot(piece, order.weapon, game.tick, rules)
            elif order.kind == Action.GUIDE_SHOOT:
                piece.cool_ends = game.tick + rules.cool_ticks
                pay_shot(pieces[order.partner], Weapon.HEAVY, game.tick, rules)
            elif order.kind == Action.INDIRECT_SHOOT:
                launch(i, order.cell, game, pieces, rounds, log, rules, cells)
            elif order.kind == Action.GET_ON:
                begin_boarding(i, order.target, BOARD_ON, game, pieces, rules)
            elif order.kind == Action.GET_OFF:
                begin_boarding(order.target, i, BOARD_OFF, game, pieces, rules)
            elif order.kind == Action.DECOMPRESS:
                begin_decompress(piece, game.tick, rules)
        if order.kind != Action.OCCUPY:
            order.kind = int(Action.NULL)


@kernel
def pay_shot(piece: PieceRecord, weapon: int, tick: int, rules: RulesRecord) -> None:
    """A round, the cool-down, and the shooter's cover."""
    spend_round(piece, weapon, rules)
    piece.cool_ends = tick + rules.cool_ticks
    piece.hidden = 0
    piece.hide_ends = NEVER


@kernel
def begin_boarding(
    soldier: PieceIndex, chariot: PieceIndex, kind: int, game: GameRecord, pieces: Pieces, rules: RulesRecord
) -> None:
    """Both partners are busy until the boarding ends; cover is lost."""
    _begin_side(pieces[soldier], chariot, kind, game.tick + rules.board_ticks)
    _begin_side(pieces[chariot], soldier, kind, game.tick + rules.board_ticks)


@kernel
def _begin_side(piece: PieceRecord, partner: PieceIndex, kind: int, ends: int) -> None:
    piece.board_ends = ends
    piece.board_kind = kind
    piece.board_partner = partner
    piece.hidden = 0


@kernel
def begin_decompress(piece: PieceRecord, tick: int, rules: RulesRecord) -> None:
    """Work free of suppression; a path that was waiting goes on afterwards."""
    piece.hidden = 0
    piece.decompress_ends = tick + rules.decompress_ticks
    if piece.arrives_at != NEVER:
        piece.arrives_at = NEVER
        piece.waiting = 1


@kernel
def occupy(game: GameRecord, pieces: Pieces, orders: Orders, log: Log, cells: Cells) -> None:
    """Occupy orders of pieces still alive: no living enemy ground piece in the cell or beside it."""
    for i in piece_range(orders.size):
        if orders[i].kind != Action.OCCUPY:
            continue
        orders[i].kind = int(Action.NULL)
        piece = pieces[i]
        if orders[i].code != Code.OK or piece.blood == 0:
            continue
        if enemy_near(piece, pieces, cells):
            orders[i].code = int(Code.POINT_CONTESTED)
            note(game, log, Event.REFUSED, i, NO_PIECE, piece.cell, Code.POINT_CONTESTED)
            continue
        game.point_owner[point_at(piece.cell, game)] = piece.camp
        note(game, log, Event.OCCUPIED, i, NO_PIECE, piece.cell, piece.camp)


@kernel
def enemy_near(piece: PieceRecord, pieces: Pieces, cells: Cells) -> bool:
    """A living enemy ground piece in the piece's cell or one of its six neighbours."""
    enemy = CampIndex(1 - piece.camp)
    if count_in(pieces, enemy, piece.cell) > 0:
        return True
    for d in range(6):
        beside = cells[piece.cell].neighbour[d]
        if beside != NO_CELL and count_in(pieces, enemy, beside) > 0:
            return True
    return False
