"""The compiled drive loop: camps act when something is new to them, the engine jumps in between.

The loop may be cut anywhere: whoever did nothing at a cut goes on as if it had not been there,
so a game is the same game at every chunk size (architecture.md, section 2).
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.act import bot_act, next_thought
from hexwar_sb3.bots.records import AtlasRecord
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.records import GameRecord, Log, Memory, Orders, Paths, Pieces, Rounds
from hexwar_sb3.engine.step import has_orders, next_due, process, set_tick
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.play.fingerprint import has_news
from hexwar_sb3.play.lower import answer_pieces, is_answered
from hexwar_sb3.play.records import BY_HAND, EARLY_TICKS, EXTERNAL, JUMPED, STEPS, WAITS, DriveRecord
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import CampIndex, camp_range, piece_range
from hexwar_sb3.tasks.execute import execute_tasks
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import ENDED, Missions, TaskKind


@kernel
def ended_tasks(camp: CampIndex, game: GameRecord, missions: Missions) -> np.uint64:
    """Bit s: the task of the camp's piece in slot s is done or impossible; a stop never counts."""
    bits = np.uint64(0)
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        if missions[i].state == ENDED and missions[i].kind != TaskKind.STOP:
            bits |= np.uint64(1) << np.uint64(i - first)
    return bits


@kernel
def wants_decision(camp: CampIndex, drive: DriveRecord, game: GameRecord, missions: Missions) -> bool:
    """Whether an own loss or an ended task calls the camp before its next regular decision.

    An ended task calls once: it stays marked in `drive.ended` until the piece has another one.
    """
    if drive.early[camp] == 0 or game.tick < drive.decided_at[camp] + EARLY_TICKS:
        return False
    lost = game.loss_tick[camp] > drive.decided_at[camp]
    return lost or (ended_tasks(camp, game, missions) & ~drive.ended[camp]) != np.uint64(0)


@kernel
def note_given(drive: DriveRecord, game: GameRecord, orders: Orders) -> None:
    """Remember the orders of this step: the engine clears them."""
    for i in piece_range(game.n_pieces):
        drive.given[i] = orders[i].kind


@kernel
def count_done(drive: DriveRecord, game: GameRecord, pieces: Pieces, orders: Orders) -> None:
    """Add the orders that the step carried out to `drive.actions`."""
    for i in piece_range(game.n_pieces):
        if drive.given[i] != Action.NULL and orders[i].code == Code.OK:
            drive.actions[pieces[i].camp, drive.given[i]] += 1


@kernel
def act(
    drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders,
    missions: Missions, brains: Rows, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord, nets: Rows,
) -> bool:  # fmt: skip
    """Let the camps whose turn it is fill `orders`: bots think first, then tasks become orders.

    It is a camp's turn when a step brought it news, when it has just decided, or when its bot wakes.

    Returns:
        False if a piece waits for an answer from outside: the loop stops, and comes back to this very state.
    """
    for camp in camp_range(2):
        if drive.seat[camp] == BY_HAND:
            continue
        stepped = game.tick == drive.stepped_at
        news = stepped and has_news(camp, drive, game, pieces, memory, rounds)
        if not news and not drive.fresh[camp] and game.tick < drive.wake_at[camp]:
            continue
        drive.fresh[camp] = 0
        if drive.seat[camp] != EXTERNAL:
            bot_act(
                drive.seat[camp], camp, game, pieces, memory, rounds, orders, missions, brains,
                rules, cells, los, eta, atlas,
            )  # fmt: skip
            drive.wake_at[camp] = next_thought(brains[camp], game.tick)
        elif is_answered(camp, drive, game):
            if not answer_pieces(
                camp, drive, game, pieces, memory, missions, rules, cells, los, eta, nets
            ):  # fmt: skip
                drive.fresh[camp] = 1
                return False
        execute_tasks(camp, game, pieces, memory, paths, rounds, orders, missions, rules, cells, los, eta)
    return True


@kernel
def jump(until: int, drive: DriveRecord, game: GameRecord, pieces: Pieces, rounds: Rounds) -> bool:
    """Without orders: set the clock to the next step that must run, at most to `until`.

    Returns:
        True if the clock moved (to that step, to `until`, or to a tick at which a bot wakes).
    """
    target = min(next_due(game, pieces, rounds), until, drive.wake_at[Camp.RED], drive.wake_at[Camp.BLUE])
    moved = target > game.tick
    set_tick(game, target, pieces)
    return moved


@kernel
def next_decision(drive: DriveRecord, game: GameRecord) -> int:
    """Tick of the next regular decision of an asked camp; the end of the game without one."""
    tick = int(game.end_tick)
    for camp in camp_range(2):
        if drive.asked[camp]:
            tick = min(tick, (game.tick // drive.period[camp] + 1) * drive.period[camp])
    return tick


@kernel
def note_due(drive: DriveRecord, game: GameRecord, missions: Missions) -> bool:
    """Mark the asked camps that are to decide in this state; True if there is one."""
    for camp in camp_range(2):
        regular = game.tick % drive.period[camp] == 0
        wanted = regular or wants_decision(camp, drive, game, missions)
        drive.due[camp] = game.over == 0 and drive.asked[camp] == 1 and wanted
    return drive.due[Camp.RED] == 1 or drive.due[Camp.BLUE] == 1


@kernel
def take_turn(
    until: int, drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders,
    missions: Missions, brains: Rows, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord, nets: Rows,
) -> int:  # fmt: skip
    """Let the camps act; STEPS if a step is to be made, JUMPED if the clock moved (at most to `until`), or WAITS."""
    if not act(
        drive, game, pieces, memory, paths, rounds, orders, missions, brains,
        rules, cells, los, eta, atlas, nets,
    ):  # fmt: skip
        return WAITS
    return JUMPED if not has_orders(orders) and jump(until, drive, game, pieces, rounds) else STEPS


@kernel
def make_step(
    drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, log: Log,
    rules: RulesRecord, cells: Cells, los: Sightlines,
) -> None:  # fmt: skip
    """Make one step of the engine and count what was carried out."""
    note_given(drive, game, orders)
    process(game, pieces, memory, paths, rounds, orders, log, rules, cells, los)
    count_done(drive, game, pieces, orders)
    drive.stepped_at = game.tick


@kernel
def advance_game(
    drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, log: Log,
    missions: Missions, brains: Rows, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord, nets: Rows,
) -> None:  # fmt: skip
    """Play one game until an asked camp is to decide, a piece waits for an answer, or the end."""
    until = next_decision(drive, game)
    while game.over == 0 and game.tick < until:
        turn = take_turn(
            until, drive, game, pieces, memory, paths, rounds, orders, missions, brains,
            rules, cells, los, eta, atlas, nets,
        )  # fmt: skip
        if turn == WAITS:
            return
        if turn == STEPS:
            make_step(drive, game, pieces, memory, paths, rounds, orders, log, rules, cells, los)
            if note_due(drive, game, missions):
                return
    note_due(drive, game, missions)


@kernel
def advance_until_decision(
    which: Rows, drives: Rows, games: Rows, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows,
    orders: Rows, log: Rows, missions: Rows, brains: Rows, rules_array: Rows, cells: Rows, los: Rows,
    eta: Rows, atlas_array: Rows, nets: Rows,
) -> None:  # fmt: skip
    """Play each of the games `which` until its next decision, a piece that waits for an answer, or its end.

    Args:
        which: games to play, [n] indices of the batch.
        drives: [B] DRIVE; then the batch arrays of the engine, [B, ...], and the world's.
        nets: LOWER_NET records that drive.lower names.
    """
    for b in which:
        advance_game(
            drives[b], games[b], pieces[b], memory[b], paths[b], rounds[b], orders[b], log[b],
            missions[b], brains[b], rules_array[0], cells, los, eta, atlas_array[0], nets,
        )  # fmt: skip
