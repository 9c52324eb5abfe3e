"""From tasks to orders, at every event (architecture.md, section 3).

Three passes over a camp's pieces, each by slot: who needs it asks the lower level; guiders and
boarders give their orders, which lay hands on a chariot; then everybody else. Only legal orders
are given, so that a refused one never costs a step. What cannot be done yet is looked at again at
the next event, because every timer that frees a piece is one.

What holds for every task:
* A control point is occupied whenever that is legal: it costs nothing.
* A settled piece, and a tank with its gun on the move, fires at what it sees from
  `mission.fire_value` on, unless `mission.hold_fire`. An attack prefers its own target.
* A piece that may not fire on the move stops, or does not move on, for a shot worth
  `mission.stop_value`.
* A chariot waits, and does not hide, while a soldier whose task is to board it stands in its cell
  and both are able to; it goes on when either is suppressed, is in close combat, or changes its task.
* A chariot whose task is to bombard does not move while its round flies: moving would lose it.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import occupy_code
from hexwar_sb3.engine.pieces import has_path, in_fight, is_settled, on_map
from hexwar_sb3.engine.records import (
    NEVER,
    NO_CELL,
    NO_PIECE,
    GameRecord,
    Memory,
    Orders,
    Paths,
    PieceRecord,
    Pieces,
    Rounds,
)
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.heuristic import heuristic_direction
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.phi import (
    give,
    give_guided,
    give_shot,
    has_flying_round,
    may_occupy,
    may_turn_back,
    phi,
)
from hexwar_sb3.tasks.progress import can_end, end_task
from hexwar_sb3.tasks.records import ENDED, STAYING, WALKING, MissionRecord, Missions, TaskKind
from hexwar_sb3.tasks.shots import best_guided, best_shot, expect_loss, is_taken, slot_bit

GUIDE_SHARE = 0.8  # a chariot whose own shot is worth this share of the guided one fires itself


@kernel
def execute_tasks(
    camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, missions: Missions,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes,
) -> None:  # fmt: skip
    """Fill orders[] of a camp's pieces from their tasks; pieces that already have an order keep it."""
    first, end = first_piece(camp, game), end_piece(camp, game)
    for i in piece_range(first, end):
        if can_end(pieces[i], missions[i]):
            end_task(i, game, pieces, memory, missions, rules)
        if needs_answer(pieces[i], missions[i], game.tick):
            ask_lower(i, game, pieces, memory, missions, rules, cells, los, eta)
    allotted = np.zeros(pieces.size, np.int64)
    taken = claimed(first, end, pieces, orders)
    for i in piece_range(first, end):
        if seeks_partner(missions[i]) and orders[i].kind == Action.NULL and not is_taken(pieces[i], taken):
            partner = order_with_partner(
                i, taken, allotted, game, pieces, memory, orders, missions, rules, cells
            )
            if partner != NO_PIECE:
                taken |= slot_bit(pieces[partner])
    for i in piece_range(first, end):
        idle = orders[i].kind == Action.NULL and not is_taken(pieces[i], taken)
        if idle and may_act(pieces[i], missions[i], game):
            order_piece(i, allotted, game, pieces, memory, paths, rounds, orders, missions, rules, cells)


@kernel
def may_act(piece: PieceRecord, mission: MissionRecord, game: GameRecord) -> bool:
    """A quick no for most pieces at most events: nothing could be ordered now anyway."""
    if not on_map(piece):
        return False
    if piece.sees != 0 and piece.cool_ends == NEVER:
        return True
    if has_path(piece) and not piece.waiting:
        news = game.contact_tick[piece.camp] == game.tick or piece.arrived_at == game.tick
        return news or mission.kind == TaskKind.STOP
    if mission.direction > 0 or occupy_code(piece, game) == Code.OK:
        return True
    return mission.state == STAYING and mission.kind != TaskKind.HOLD and mission.kind != TaskKind.ATTACK


@kernel
def claimed(first: PieceIndex, end: PieceIndex, pieces: Pieces, orders: Orders) -> np.uint64:
    """Bits of the chariots that orders already given lay hands on, by slot."""
    taken = np.uint64(0)
    for i in piece_range(first, end):
        if orders[i].kind == Action.GUIDE_SHOOT:
            taken |= slot_bit(pieces[orders[i].partner])
        elif orders[i].kind == Action.GET_ON:
            taken |= slot_bit(pieces[orders[i].target])
    return taken


@kernel
def needs_answer(piece: PieceRecord, mission: MissionRecord, tick: int) -> bool:
    """The piece has just arrived in a cell or been given its task, and stands at a cell's centre."""
    if mission.state == ENDED or mission.asked_at == tick:
        return False
    if has_path(piece) and not piece.waiting:
        return mission.kind == TaskKind.STOP
    return piece.arrived_at == tick or mission.chosen_at == tick


@kernel
def ask_lower(
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
    eta: TravelTimes,
) -> None:
    """Ask the lower level once, and keep its answer until the next cell or decision."""
    mission = missions[i]
    mission.asked_at = game.tick
    mission.direction = 0
    if mission.kind != TaskKind.STOP and mission.kind != TaskKind.RECOVER:
        mission.direction = heuristic_direction(i, pieces, memory, missions, rules, cells, los, eta)
    mission.state = STAYING if mission.direction == 0 else WALKING


@kernel
def seeks_partner(mission: MissionRecord) -> bool:
    """The task's action lays hands on a chariot, and the piece is at its place."""
    return mission.state == STAYING and (mission.kind == TaskKind.BOARD or mission.kind == TaskKind.GUIDE)


@kernel
def order_with_partner(
    i: PieceIndex, taken: np.uint64, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, orders: Orders, missions: Missions,
    rules: RulesRecord, cells: Cells,
) -> PieceIndex:  # fmt: skip
    """Guide or board, where that is the task and legal now; the chariot it takes, or NO_PIECE."""
    mission = missions[i]
    if mission.kind == TaskKind.BOARD:
        free = orders[mission.target].kind == Action.NULL and not is_taken(pieces[mission.target], taken)
        given = free and phi(i, 0, game, pieces, memory, orders, missions, rules, cells)
        return PieceIndex(mission.target) if given else NO_PIECE
    value, target, chariot = best_guided(
        i, mission.target, taken, allotted, game, pieces, memory, orders, rules, cells
    )
    if target == NO_PIECE or fires_itself(
        chariot, value, allotted, game, pieces, memory, missions, rules, cells
    ):
        return NO_PIECE
    if not give_guided(i, target, chariot, game, pieces, orders, rules, cells):
        return NO_PIECE
    expect_loss(chariot, target, Weapon.HEAVY, allotted, game, pieces, memory, rules, cells)
    return chariot


@kernel
def fires_itself(
    c: PieceIndex, guided_value: float, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions,
    rules: RulesRecord, cells: Cells,
) -> bool:  # fmt: skip
    """The chariot's own shot is about as good as the one that it would be guided to."""
    if missions[c].hold_fire:
        return False
    value, _, _ = best_shot(c, NO_PIECE, False, allotted, game, pieces, memory, rules, cells)
    return value >= missions[c].fire_value and value >= GUIDE_SHARE * guided_value


@kernel
def order_piece(
    i: PieceIndex, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, rounds: Rounds, orders: Orders, missions: Missions,
    rules: RulesRecord, cells: Cells,
) -> None:  # fmt: skip
    """The one order that serves piece i's task best in this step, if any."""
    piece = pieces[i]
    mission = missions[i]
    settled = is_settled(piece)
    if may_occupy(i, game, pieces, memory, cells):
        give(i, Action.OCCUPY, NO_PIECE, NO_CELL, game, pieces, orders, rules, cells)
    elif settled and fire(i, allotted, game, pieces, memory, orders, missions, rules, cells):
        return
    elif has_path(piece):
        if not halt(i, allotted, game, pieces, memory, paths, orders, missions, rules, cells):
            fire(i, allotted, game, pieces, memory, orders, missions, rules, cells)
    elif mission.direction > 0:
        stays = waits(i, rounds, game, pieces, missions) or is_worth_a_stop(
            i, allotted, game, pieces, memory, missions, rules, cells
        )
        moves = not stays and phi(i, mission.direction, game, pieces, memory, orders, missions, rules, cells)
        if not moves and not settled:
            fire(i, allotted, game, pieces, memory, orders, missions, rules, cells)
    elif settled or not fire(i, allotted, game, pieces, memory, orders, missions, rules, cells):
        if mission.state == STAYING and acts_alone(i, game, pieces, missions):
            phi(i, 0, game, pieces, memory, orders, missions, rules, cells)


@kernel
def acts_alone(i: PieceIndex, game: GameRecord, pieces: Pieces, missions: Missions) -> bool:
    """The task's action needs no partner, and nobody who needs this chariot would miss it."""
    kind = missions[i].kind
    if kind == TaskKind.HIDE or kind == TaskKind.SHADOW:
        return not is_awaited(i, game, pieces, missions)
    return kind != TaskKind.BOARD and kind != TaskKind.GUIDE


@kernel
def fire(
    i: PieceIndex, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, orders: Orders, missions: Missions, rules: RulesRecord,
    cells: Cells,
) -> bool:  # fmt: skip
    """The task's own shot, else one of opportunity, if the mission's fire style allows it."""
    mission = missions[i]
    value, target, weapon = 0.0, NO_PIECE, 0
    if mission.kind == TaskKind.ATTACK and mission.state != ENDED:
        value, target, weapon = best_shot(
            i, mission.target, False, allotted, game, pieces, memory, rules, cells
        )
    own_target = value > 0.0 and (mission.state == STAYING or value >= mission.fire_value)
    if not own_target and not mission.hold_fire:
        value, target, weapon = best_shot(i, NO_PIECE, False, allotted, game, pieces, memory, rules, cells)
    if not own_target and (mission.hold_fire or target == NO_PIECE or value < mission.fire_value):
        return False
    given = give_shot(i, target, weapon, game, pieces, orders, rules, cells)
    if given:
        expect_loss(i, target, weapon, allotted, game, pieces, memory, rules, cells)
    return given


@kernel
def is_worth_a_stop(
    i: PieceIndex,
    allotted: Rows,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """A piece that cannot fire on the move has a shot from here that it should stand for."""
    mission = missions[i]
    if rules.moving_fire[pieces[i].kind] or mission.hold_fire or in_fight(game, pieces[i]):
        return False
    value, _, _ = best_shot(i, NO_PIECE, True, allotted, game, pieces, memory, rules, cells)
    return value > 0.0 and value >= mission.stop_value


@kernel
def halt(
    i: PieceIndex, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, orders: Orders, missions: Missions,
    rules: RulesRecord, cells: Cells,
) -> bool:  # fmt: skip
    """Stop a piece under way: for its task, for another way than it waits for, or for a shot."""
    piece = pieces[i]
    mission = missions[i]
    if not may_turn_back(piece, game.tick):
        return False
    stops = mission.kind == TaskKind.STOP and mission.state != ENDED
    if piece.waiting and mission.asked_at == game.tick:
        stops = stops or mission.direction != 1 + paths[i, piece.path_pos]
    if game.contact_tick[piece.camp] == game.tick:
        stops = stops or is_worth_a_stop(i, allotted, game, pieces, memory, missions, rules, cells)
    return stops and give(i, Action.STOP, NO_PIECE, NO_CELL, game, pieces, orders, rules, cells)


@kernel
def waits(i: PieceIndex, rounds: Rounds, game: GameRecord, pieces: Pieces, missions: Missions) -> bool:
    """The piece should not move on yet: somebody boards it, or its round is in the air."""
    if missions[i].kind == TaskKind.BOMBARD and has_flying_round(i, rounds):
        return True
    return is_awaited(i, game, pieces, missions)


@kernel
def is_awaited(i: PieceIndex, game: GameRecord, pieces: Pieces, missions: Missions) -> bool:
    """A soldier whose task is to board this chariot stands in its cell, and both are able to."""
    chariot = pieces[i]
    if chariot.kind != PieceType.CHARIOT or chariot.passenger != NO_PIECE or chariot.suppressed:
        return False
    if in_fight(game, chariot):
        return False
    for s in piece_range(first_piece(chariot.camp, game), end_piece(chariot.camp, game)):
        boards = (
            missions[s].kind == TaskKind.BOARD and missions[s].target == i and missions[s].state == STAYING
        )
        soldier = pieces[s]
        if boards and on_map(soldier) and soldier.cell == chariot.cell and not soldier.suppressed:
            return True
    return False
