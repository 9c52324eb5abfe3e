"""One step of the game, and the jump to the next one that matters (rule book, section 5).

`process` makes the step of game.tick: it reads both camps' orders, fires from the state at the
start of the step, and leaves the state of the next tick. Steps in which nothing is due change
nothing but the clock, so `advance` jumps over them; making every step gives the same state.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.actions import judge_orders, occupy, start_orders
from hexwar_sb3.engine.fights import (
    close_fights,
    fire_exchanges,
    fire_exit_shots,
    open_fights,
    spend_close_rounds,
)
from hexwar_sb3.engine.fire import fire_orders
from hexwar_sb3.engine.harm import apply_results
from hexwar_sb3.engine.mortar import cancel_rounds, judge_entering, land_rounds
from hexwar_sb3.engine.movement import arrive, start_hops
from hexwar_sb3.engine.records import (
    NEVER,
    NO_CELL,
    ROUND_BURSTING,
    ROUND_FLYING,
    GameRecord,
    Log,
    Memory,
    Orders,
    Paths,
    Pieces,
    Rounds,
)
from hexwar_sb3.engine.sight import is_covered, look_around, remember
from hexwar_sb3.engine.timers import end_timers
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import piece_range


@kernel
def process(
    game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, log: Log, rules: RulesRecord,
    cells: Cells, los: Sightlines,
) -> None:  # fmt: skip
    """Make the step of game.tick; orders are read, answered with a code, and cleared."""
    note_cover(pieces)
    ordered = has_orders(orders)
    fighting = has_fights(game)
    if ordered:
        judge_orders(game, pieces, orders, log, rules, cells)
        cancel_rounds(orders, rounds)
        fire_orders(game, pieces, orders, log, rules, cells)
    if fighting:
        fire_exit_shots(game, pieces, orders, log, rules, cells)
        fire_exchanges(game, pieces, log, rules, cells)
    land_rounds(game, pieces, rounds, log, rules, cells, los)
    if ordered:
        start_orders(game, pieces, paths, rounds, orders, log, rules, cells)
    if fighting:
        spend_close_rounds(pieces)
    apply_results(game, pieces, log, rules)
    if ordered:
        occupy(game, pieces, orders, log, cells)
    start_hops(game.tick, game, pieces, paths, log, rules, cells)
    if arrive(game, pieces, paths, log, rules, cells):
        judge_entering(game, pieces, rounds, log, rules, cells)
        apply_results(game, pieces, log, rules)
        open_fights(game, pieces, log)
    if end_timers(game, pieces, rounds, log, rules):
        judge_entering(game, pieces, rounds, log, rules, cells)
        apply_results(game, pieces, log, rules)
    if has_fights(game):
        close_fights(game, pieces)
    start_hops(game.tick + 1, game, pieces, paths, log, rules, cells)
    set_tick(game, game.tick + 1, pieces)
    look_around(pieces, rules, cells, los)
    remember(game, pieces, memory, paths, cells)


@kernel
def has_orders(orders: Orders) -> bool:
    """Is any order given?"""
    for i in piece_range(orders.size):
        if orders[i].kind != Action.NULL:
            return True
    return False


@kernel
def has_fights(game: GameRecord) -> bool:
    """Is there a close combat anywhere?"""
    return game.n_fights > 0


@kernel
def note_cover(pieces: Pieces) -> None:
    """Mark who is hidden or aboard as the step begins."""
    for i in piece_range(pieces.size):
        pieces[i].covered_now = 1 if is_covered(pieces[i]) else 0


@kernel
def set_tick(game: GameRecord, tick: int, pieces: Pieces) -> None:
    """Move the clock; the game ends at its last tick, or early where that is allowed."""
    game.tick = tick
    if tick >= game.end_tick or (game.early_end and is_wiped_out(pieces)):
        game.over = 1


@kernel
def is_wiped_out(pieces: Pieces) -> bool:
    """Has one camp no piece left?"""
    alive = np.zeros(2, np.int64)
    for i in piece_range(pieces.size):
        if pieces[i].blood > 0:
            alive[pieces[i].camp] += 1
    return alive[0] == 0 or alive[1] == 0


@kernel
def next_due(game: GameRecord, pieces: Pieces, rounds: Rounds) -> int:
    """The earliest step, at or after game.tick, in which something is due; NEVER: none."""
    end = NEVER
    for i in piece_range(pieces.size):
        piece = pieces[i]
        if piece.blood == 0:
            continue
        end = min(
            end, int(piece.arrives_at), int(piece.stop_ends), int(piece.hide_ends), int(piece.board_ends),
            int(piece.decompress_ends), int(piece.cool_ends), int(piece.mortar_ends),
            int(piece.keep_ends),
        )  # fmt: skip
    for r in range(rounds.size):
        if rounds[r].status == ROUND_FLYING:
            end = min(end, int(rounds[r].land_at))
        elif rounds[r].status == ROUND_BURSTING:
            end = min(end, int(rounds[r].end_at))
    due = NEVER if end == NEVER else end - 1
    for f in range(game.n_fights):
        if game.fight_cell[f] != NO_CELL:
            due = min(due, int(game.fight_next[f]))
    return max(due, int(game.tick))


@kernel
def advance(
    until: int, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, log: Log,
    rules: RulesRecord, cells: Cells, los: Sightlines,
) -> None:  # fmt: skip
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
    until: int, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, log: Log,
    rules: RulesRecord, cells: Cells, los: Sightlines,
) -> None:  # fmt: skip
    """The same, making every step: the oracle of `advance`."""
    while game.tick < until and not game.over:
        process(game, pieces, memory, paths, rounds, orders, log, rules, cells, los)
