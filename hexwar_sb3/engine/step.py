"""One step of the game, and the jump to the next one that matters (rule book, section 5).

`process` makes the step of game.tick: it reads both camps' orders, fires from the state at the
start of the step, and leaves the state of the next tick. Steps in which nothing is due change
nothing but the clock, so `advance` jumps over them; making every step gives the same state.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.dice import priority
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.fights import close_fights, fire_exchanges, fire_exit_shots, open_fights, spend_close_rounds
from hexwar_sb3.engine.fire import resolve_shot
from hexwar_sb3.engine.harm import apply_results
from hexwar_sb3.engine.legality import order_code, point_at
from hexwar_sb3.engine.mortar import judge_entering, land_rounds, launch
from hexwar_sb3.engine.movement import arrive, begin_move, begin_stop, start_hops
from hexwar_sb3.engine.pieces import cancel_boarding, count_in, spend_round
from hexwar_sb3.engine.records import (
    BOARD_OFF,
    BOARD_ON,
    NEVER,
    NO_CELL,
    NO_PIECE,
    ROUND_BURSTING,
    ROUND_FLYING,
    ROUND_FREE,
)
from hexwar_sb3.engine.sight import look_around, remember
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.rules.enums import Action, PieceType, Weapon

_ONE = np.uint32(1)


@kernel
def process(
    game: Row, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows, los: Rows
) -> None:
    """Make the step of game.tick; orders are read, answered with a code, and cleared."""
    hidden_before = hidden_bits(pieces)
    ordered = has_orders(orders)
    fighting = has_fights(game)
    if ordered:
        judge_orders(game, pieces, orders, log, rules, cells)
        fire_orders(game, pieces, orders, log, rules, cells)
    if fighting:
        fire_exit_shots(game, pieces, orders, log, rules, cells)
        fire_exchanges(game, pieces, log, rules, cells)
    land_rounds(game, pieces, rounds, log, rules, cells, los)
    if ordered:
        start_orders(game, pieces, paths, rounds, orders, log, rules, cells)
    if fighting:
        spend_close_rounds(pieces)
    changed = apply_results(game, pieces, log, rules)
    if ordered:
        occupy(game, pieces, orders, log, cells)
    start_hops(game.tick, game, pieces, paths, log, rules, cells)
    entered = arrive(game, pieces, paths, log, rules, cells)
    changed |= entered
    if entered != 0:
        judge_entering(entered, game, pieces, rounds, log, rules, cells)
        changed |= apply_results(game, pieces, log, rules)
        changed |= open_fights(game, pieces, log)
    stepped_off = end_timers(game, pieces, rounds, log, rules)
    if stepped_off != 0:
        judge_entering(stepped_off, game, pieces, rounds, log, rules, cells)
        changed |= stepped_off | apply_results(game, pieces, log, rules)
    if has_fights(game):
        close_fights(game, pieces)
    start_hops(game.tick + 1, game, pieces, paths, log, rules, cells)
    set_tick(game, game.tick + 1, pieces)
    changed |= hidden_before ^ hidden_bits(pieces)
    look_around(changed, pieces, rules, cells, los)
    remember(game, pieces, memory, paths, cells)


@kernel
def has_orders(orders: Rows) -> bool:
    """Is any order given?"""
    for i in range(orders.size):
        if orders[i].kind != Action.NULL:
            return True
    return False


@kernel
def has_fights(game: Row) -> bool:
    """Is there a close combat anywhere?"""
    for f in range(game.fight_cell.size):
        if game.fight_cell[f] != NO_CELL:
            return True
    return False


@kernel
def hidden_bits(pieces: Rows) -> np.uint32:
    """Bits of the pieces that are hidden or aboard: what changes their visibility in place."""
    bits = np.uint32(0)
    for i in range(pieces.size):
        if pieces[i].hidden or pieces[i].carrier != NO_PIECE:
            bits |= _ONE << np.uint32(i)
    return bits


@kernel
def judge_orders(game: Row, pieces: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows) -> None:
    """Write the code of every order: first each alone, then against the own camp's other orders."""
    for i in range(orders.size):
        orders[i].code = int(order_code(i, orders[i], game, pieces, rules, cells))
    for i in range(orders.size):
        if orders[i].code == Code.OK and needs_partner(orders[i]):
            orders[i].code = int(partner_code(i, game, pieces, orders))
    for i in range(orders.size):
        if orders[i].code != Code.OK:
            note(game, log, Event.REFUSED, i, NO_PIECE, pieces[i].cell, orders[i].code)


@kernel
def needs_partner(order: Row) -> bool:
    """Does the order lay hands on another own piece?"""
    return order.kind == Action.GUIDE_SHOOT or order.kind == Action.GET_ON


@kernel
def partner_of(order: Row) -> int:
    """The chariot that an order of guiding or boarding claims."""
    return order.partner if order.kind == Action.GUIDE_SHOOT else order.target


@kernel
def partner_code(i: int, game: Row, pieces: Rows, orders: Rows) -> int:
    """The claimed chariot must have no order of its own, and no rival of better priority."""
    chariot = partner_of(orders[i])
    if orders[chariot].kind != Action.NULL and orders[chariot].code == Code.OK:
        return Code.PARTNER_BUSY
    for j in range(orders.size):
        rival = j != i and orders[j].kind == orders[i].kind and partner_of(orders[j]) == chariot
        if not rival or (orders[j].code != Code.OK and orders[j].code != Code.CONFLICT):
            continue
        if priority(game, game.tick, pieces[j]) < priority(game, game.tick, pieces[i]):
            return Code.CONFLICT
    return Code.OK


@kernel
def fire_orders(game: Row, pieces: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows) -> None:
    """Throw the dice of every shot that was ordered; nothing changes but the collected results."""
    for i in range(orders.size):
        order = orders[i]
        if order.code != Code.OK:
            continue
        if order.kind == Action.SHOOT:
            resolve_shot(Event.SHOT, i, i, order.target, order.weapon, False, game, pieces, log, rules, cells)
        elif order.kind == Action.GUIDE_SHOOT:
            resolve_shot(Event.GUIDED, i, order.partner, order.target, Weapon.HEAVY, False, game, pieces, log, rules, cells)


@kernel
def start_orders(
    game: Row, pieces: Rows, paths: Rows, rounds: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows
) -> None:
    """Begin what the legal orders say, and pay for the shots; occupy comes after the fire."""
    for i in range(orders.size):
        order = orders[i]
        piece = pieces[i]
        if order.code == Code.OK:
            if order.kind == Action.MOVE:
                begin_move(i, order, pieces, paths, rounds)
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
def pay_shot(piece: Row, weapon: int, tick: int, rules: Row) -> None:
    """A round, the cool-down, and the shooter's cover."""
    spend_round(piece, weapon, rules)
    piece.cool_ends = tick + rules.cool_ticks
    piece.hidden = 0
    piece.hide_ends = NEVER


@kernel
def begin_boarding(soldier: int, chariot: int, kind: int, game: Row, pieces: Rows, rules: Row) -> None:
    """Both partners are busy until the boarding ends; cover is lost."""
    _begin_side(pieces[soldier], chariot, kind, game.tick + rules.board_ticks)
    _begin_side(pieces[chariot], soldier, kind, game.tick + rules.board_ticks)


@kernel
def _begin_side(piece: Row, partner: int, kind: int, ends: int) -> None:
    piece.board_ends = ends
    piece.board_kind = kind
    piece.board_partner = partner
    piece.hidden = 0


@kernel
def begin_decompress(piece: Row, tick: int, rules: Row) -> None:
    """Work free of suppression; a path that was waiting goes on afterwards."""
    piece.hidden = 0
    piece.decompress_ends = tick + rules.decompress_ticks
    if piece.arrives_at != NEVER:
        piece.arrives_at = NEVER
        piece.waiting = 1


@kernel
def occupy(game: Row, pieces: Rows, orders: Rows, log: Rows, cells: Rows) -> None:
    """Occupy orders of pieces still alive: no living enemy ground piece in the cell or beside it."""
    for i in range(orders.size):
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
def enemy_near(piece: Row, pieces: Rows, cells: Rows) -> bool:
    """A living enemy ground piece in the piece's cell or one of its six neighbours."""
    enemy = 1 - piece.camp
    if count_in(pieces, enemy, piece.cell) > 0:
        return True
    for d in range(6):
        beside = cells[piece.cell].neighbour[d]
        if beside != NO_CELL and count_in(pieces, enemy, beside) > 0:
            return True
    return False


@kernel
def end_timers(game: Row, pieces: Rows, rounds: Rows, log: Rows, rules: Row) -> np.uint32:
    """Timers that end with this step take effect; bits of the soldiers that got off."""
    now = game.tick + 1
    got_off = np.uint32(0)
    for i in range(pieces.size):
        piece = pieces[i]
        if piece.cool_ends <= now:
            piece.cool_ends = NEVER
        if piece.mortar_ends <= now:
            piece.mortar_ends = NEVER
        if piece.stop_ends <= now:
            piece.stop_ends = NEVER
            piece.stop_forced = 0
        if piece.hide_ends <= now:
            piece.hide_ends = NEVER
            piece.hidden = 1
            note(game, log, Event.HIDDEN, i, NO_PIECE, piece.cell, 0)
        if piece.keep_ends <= now or piece.decompress_ends <= now:
            release(piece)
            note(game, log, Event.RELEASED, i, NO_PIECE, piece.cell, 0)
        if piece.board_ends <= now and piece.board_kind == BOARD_ON:
            end_get_on(i, game, pieces, log)
        elif piece.board_ends <= now and piece.board_kind == BOARD_OFF:
            got_off |= end_get_off(i, game, pieces, log, rules)
    for r in range(rounds.size):
        if rounds[r].status == ROUND_BURSTING and rounds[r].end_at <= now:
            rounds[r].status = ROUND_FREE
    return got_off


@kernel
def release(piece: Row) -> None:
    """Suppression ends, by itself or by decompressing."""
    piece.suppressed = 0
    piece.keep_ends = NEVER
    piece.decompress_ends = NEVER


@kernel
def end_get_on(i: int, game: Row, pieces: Rows, log: Rows) -> None:
    """The soldier is aboard (called for whichever partner comes first)."""
    partner = int(pieces[i].board_partner)
    soldier, chariot = (i, partner) if pieces[i].kind == PieceType.SOLDIER else (partner, i)
    cancel_boarding(i, pieces)
    pieces[soldier].carrier = chariot
    pieces[chariot].passenger = soldier
    note(game, log, Event.ABOARD, soldier, chariot, pieces[chariot].cell, 0)


@kernel
def end_get_off(i: int, game: Row, pieces: Rows, log: Rows, rules: Row) -> np.uint32:
    """The soldier stands in the cell, or waits aboard where the cell filled up meanwhile."""
    partner = int(pieces[i].board_partner)
    soldier, chariot = (i, partner) if pieces[i].carrier != NO_PIECE else (partner, i)
    cancel_boarding(i, pieces)
    cell = pieces[chariot].cell
    if count_in(pieces, pieces[chariot].camp, cell) >= rules.stack_limit:
        note(game, log, Event.GETOFF_BLOCKED, soldier, chariot, cell, 0)
        return np.uint32(0)
    pieces[soldier].carrier = NO_PIECE
    pieces[soldier].cell = cell
    pieces[soldier].arrived_at = game.tick + 1
    pieces[chariot].passenger = NO_PIECE
    note(game, log, Event.OFF, soldier, chariot, cell, 0)
    return _ONE << np.uint32(soldier)


@kernel
def set_tick(game: Row, tick: int, pieces: Rows) -> None:
    """Move the clock; the game ends at its last tick, or early where that is allowed."""
    game.tick = tick
    if tick >= game.end_tick or (game.early_end and is_wiped_out(pieces)):
        game.over = 1


@kernel
def is_wiped_out(pieces: Rows) -> bool:
    """Has one camp no piece left?"""
    alive = np.zeros(2, np.int64)
    for i in range(pieces.size):
        if pieces[i].blood > 0:
            alive[pieces[i].camp] += 1
    return alive[0] == 0 or alive[1] == 0


@kernel
def next_due(game: Row, pieces: Rows, rounds: Rows) -> int:
    """The earliest step, at or after game.tick, in which something is due; NEVER: none."""
    end = NEVER
    for i in range(pieces.size):
        piece = pieces[i]
        if piece.blood == 0:
            continue
        end = min(
            end,
            int(piece.arrives_at),
            int(piece.stop_ends),
            int(piece.hide_ends),
            int(piece.board_ends),
            int(piece.decompress_ends),
            int(piece.cool_ends),
            int(piece.mortar_ends),
            int(piece.keep_ends),
        )
    for r in range(rounds.size):
        if rounds[r].status == ROUND_FLYING:
            end = min(end, int(rounds[r].land_at))
        elif rounds[r].status == ROUND_BURSTING:
            end = min(end, int(rounds[r].end_at))
    due = NEVER if end == NEVER else end - 1
    for f in range(game.fight_cell.size):
        if game.fight_cell[f] != NO_CELL:
            due = min(due, int(game.fight_next[f]))
    return max(due, int(game.tick))


@kernel
def advance(
    until: int, game: Row, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows, los: Rows
) -> None:
    """Play to the state of tick `until` (or the end), jumping over steps in which nothing is due."""
    while game.tick < until and not game.over:
        due = int(game.tick) if has_orders(orders) else next_due(game, pieces, rounds)
        if due >= min(until, int(game.end_tick)):
            set_tick(game, min(until, int(game.end_tick)), pieces)
            break
        game.tick = due
        process(game, pieces, memory, paths, rounds, orders, log, rules, cells, los)


@kernel
def advance_by_ticks(
    until: int, game: Row, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows, log: Rows, rules: Row, cells: Rows, los: Rows
) -> None:
    """The same, making every step: the oracle of `advance`."""
    while game.tick < until and not game.over:
        process(game, pieces, memory, paths, rounds, orders, log, rules, cells, los)
