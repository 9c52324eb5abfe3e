"""What a camp's networks read: observations and the mixer's state, in the order of features.py.

An observation reads own pieces, control points and `memory[camp]`, and of the enemy nothing else.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.legality import point_at
from hexwar_sb3.engine.pieces import hop_from, in_fight, in_motion, is_busy, is_settled, on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.engine.score import known_margin, margin
from hexwar_sb3.engine.sight import sees_itself
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart, frame_cell, frame_direction
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, camp_range, piece_range, point_range
from hexwar_sb3.tasks.features import (
    MOST,
    PER_BLOOD,
    PER_CELL,
    PER_COUNT,
    PER_GAME,
    PER_LEVEL,
    PER_MARGIN,
    PER_POINT,
    PER_TIMER,
    PER_VALUE,
    PER_WAY,
    group_width,
)
from hexwar_sb3.tasks.known import age, end_piece, first_piece, known_in_zone, n_slots, ticks_left
from hexwar_sb3.tasks.records import MissionRecord, Missions, TaskSets
from hexwar_sb3.tasks.shots import best_shot
from hexwar_sb3.tasks.task_rows import N_TASKS, N_TYPES, bounded, put_way, write_rows
from hexwar_sb3.tasks.travel import travel_ticks

OWN_WIDTH = group_width("obs", "own piece")
ENEMY_WIDTH = group_width("obs", "enemy")
PIECE_WIDTH = group_width("state", "piece")


@kernel
def observe(
    camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes,
    tasks: TaskSets, mask: Rows, obs: Rows, rows: Rows, alive: Rows,
) -> None:  # fmt: skip
    """Write one camp's observation (fogged, in the camp's frame); an empty slot reads as a destroyed piece.

    Args:
        tasks, mask: the camp's task sets, from `list_tasks`, [N, K].
        obs: out, f4 [N, Do]; alive: out, f4 [N].
        rows: out, f4 [N, K, Dt]; zeros, or what was written to it last.
    """
    first = first_piece(camp, game)
    n_own = end_piece(camp, game) - first
    obs[:] = 0.0
    alive[:] = 0.0
    rows[n_own:] = 0.0
    for n in range(n_own):
        i = PieceIndex(first + n)
        alive[n] = 1.0 if pieces[i].blood > 0 else 0.0
        if pieces[i].blood > 0:
            at = _put_self(obs[n], i, game, pieces, memory, missions, rules, cells)
            at = _put_neighbours(obs[n], at, pieces[i], rules, cells)
            at = _put_own(obs[n], at, i, game, pieces, cells)
            at = _put_enemies(obs[n], at, i, game, pieces, memory, cells)
            at = _put_points(obs[n], at, i, game, pieces, memory, rules, cells, eta)
            _put_game(obs[n], at, camp, game, known_margin(game, pieces, memory, camp, rules))
        write_rows(i, game, pieces, memory, missions, rules, cells, los, eta, tasks[n], mask[n], rows[n])


@kernel
def _put_self(
    out: Rows,
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    piece = pieces[i]
    out[piece.kind] = 1.0
    out[N_TYPES + i - first_piece(piece.camp, game)] = 1.0
    at = N_TYPES + n_slots(game)
    framed = frame_cell(cells, piece.cell, piece.camp)
    out[at] = cells[framed].x * PER_CELL - 1.0
    out[at + 1] = cells[framed].y * PER_CELL - 1.0
    out[at + 2] = piece.blood * PER_BLOOD
    out[at + 3] = rules.value[piece.kind] * PER_VALUE
    out[at + 4] = 1.0 if in_motion(piece) else 0.0
    out[at + 5] = 1.0 if is_settled(piece) else 0.0
    out[at + 6] = 1.0 if is_busy(piece) else 0.0
    out[at + 7] = 1.0 if in_fight(game, piece) else 0.0
    out[at + 8] = piece.hidden
    out[at + 9] = piece.suppressed
    at = _put_timers(out, at + 10, piece, game.tick)
    for pool in range(piece.ammo.size):
        full = max(1, int(rules.pool_ammo[piece.kind, pool]))
        out[at + pool] = piece.ammo[pool] / full
    at += piece.ammo.size
    out[at] = 0.0 if piece.passenger == NO_PIECE else 1.0
    out[at + 1] = partner_cells(i, game, pieces, cells) * PER_CELL
    out[at + 2] = 0.0 if point_at(piece.cell, game) < 0 else 1.0
    out[at + 3] = cells[piece.cell].concealed
    out[at + 4] = cells[piece.cell].exposure
    at = _put_shots(out, at + 5, i, game, pieces, memory, rules, cells)
    return _put_mission(out, at, piece, missions[i], cells)


@kernel
def _put_timers(out: Rows, at: int, piece: PieceRecord, tick: int) -> int:
    out[at] = ticks_left(piece.cool_ends, tick) * PER_TIMER
    out[at + 1] = ticks_left(piece.stop_ends, tick) * PER_TIMER
    out[at + 2] = ticks_left(piece.hide_ends, tick) * PER_TIMER
    out[at + 3] = ticks_left(piece.board_ends, tick) * PER_TIMER
    out[at + 4] = ticks_left(piece.decompress_ends, tick) * PER_TIMER
    out[at + 5] = ticks_left(piece.keep_ends, tick) * PER_TIMER
    out[at + 6] = ticks_left(piece.mortar_ends, tick) * PER_TIMER
    return at + 7


@kernel
def partner_cells(i: PieceIndex, game: GameRecord, pieces: Pieces, cells: Cells) -> int:
    """Distance of a soldier from its chariot, or of a chariot from its soldier; 0 without one."""
    piece = pieces[i]
    for k in piece_range(first_piece(piece.camp, game), end_piece(piece.camp, game)):
        belongs = piece.home == k or (pieces[k].home == i and piece.kind == PieceType.CHARIOT)
        if belongs and pieces[k].blood > 0:
            return cells_apart(cells, piece.cell, pieces[k].cell)
    return 0


@kernel
def _put_shots(
    out: Rows,
    at: int,
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    piece = pieces[i]
    seen = 0
    for j in piece_range(
        first_piece(CampIndex(1 - piece.camp), game), end_piece(CampIndex(1 - piece.camp), game)
    ):
        seen += 1 if sees_itself(piece, pieces[j]) else 0
    if seen > 0:
        allotted = np.zeros(pieces.size, np.int64)
        now, _, _ = best_shot(i, NO_PIECE, False, allotted, game, pieces, memory, rules, cells)
        settled, _, _ = best_shot(i, NO_PIECE, True, allotted, game, pieces, memory, rules, cells)
        out[at] = seen * PER_COUNT
        out[at + 1] = bounded(now * PER_VALUE)
        out[at + 2] = bounded(settled * PER_VALUE)
    return at + 3


@kernel
def _put_mission(out: Rows, at: int, piece: PieceRecord, mission: MissionRecord, cells: Cells) -> int:
    out[at + mission.kind] = 1.0
    at += N_TASKS
    out[at + mission.state] = 1.0
    if mission.goal != NO_CELL:
        put_way(out, at + 3, piece.camp, piece.cell, mission.goal, cells)
    return at + 6


@kernel
def _put_neighbours(out: Rows, at: int, piece: PieceRecord, rules: RulesRecord, cells: Cells) -> int:
    """Properties of the six cells around, in the order of the camp's directions."""
    here = cells[piece.cell]
    for framed in range(6):
        d = frame_direction(framed, piece.camp)
        if here.neighbour[d] != NO_CELL:
            there = cells[here.neighbour[d]]
            hop = hop_from(piece.kind, piece.cell, d, rules, cells)
            out[at] = bounded((int(there.level) - int(here.level)) * PER_LEVEL)
            out[at + 1] = there.controllable
            out[at + 2] = there.passable
            out[at + 3] = there.paved
            out[at + 4] = there.concealed
            out[at + 5] = there.slushy
            out[at + 6] = rules.base_hop[piece.kind] / hop if hop > 0 else 0.0
        at += 7
    return at


@kernel
def _put_own(out: Rows, at: int, i: PieceIndex, game: GameRecord, pieces: Pieces, cells: Cells) -> int:
    camp, start = pieces[i].camp, at
    for k in piece_range(first_piece(camp, game), end_piece(camp, game)):
        other = pieces[k]
        if other.blood > 0:
            out[at] = 1.0
            out[at + 1] = 0.0 if other.carrier == NO_PIECE else 1.0
            put_way(out, at + 2, camp, pieces[i].cell, other.cell, cells)
            out[at + 5] = other.blood * PER_BLOOD
            out[at + 6] = other.suppressed
            out[at + 7] = other.hidden
        at += OWN_WIDTH
    return start + OWN_WIDTH * n_slots(game)


@kernel
def _put_enemies(
    out: Rows, at: int, i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, cells: Cells
) -> int:
    """u(sigma, t): the enemies as the camp last saw them (III-A)."""
    camp, start = pieces[i].camp, at
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        if known.cell == NO_CELL:
            out[at] = 1.0
        elif known.blood == 0:
            out[at + 1] = 1.0
        else:
            out[at + 2] = known.seen
            out[at + 3] = 1.0 if sees_itself(pieces[i], pieces[j]) else 0.0
            out[at + 4] = bounded(age(known, game.tick) * PER_GAME)
            put_way(out, at + 5, camp, pieces[i].cell, known.cell, cells)
            out[at + 8] = known.blood * PER_BLOOD
            out[at + 9] = known.hidden
            out[at + 10] = known.suppressed
            out[at + 11] = known.moving
        at += ENEMY_WIDTH
    return start + ENEMY_WIDTH * n_slots(game)


@kernel
def _put_points(
    out: Rows,
    at: int,
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
) -> int:
    piece = pieces[i]
    for k in point_range(game.n_points):
        cell = game.point_cell[k]
        put_way(out, at, piece.camp, piece.cell, cell, cells)
        at = _put_owner(out, at + 3, piece.camp, game.point_owner[k])
        way = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
        out[at] = game.point_value[k] * PER_POINT
        out[at + 1] = min(way * PER_WAY, MOST)
        out[at + 2] = known_in_zone(piece.camp, cell, game, pieces, memory, cells) * PER_COUNT
        at += 3
    return at


@kernel
def _put_owner(out: Rows, at: int, camp: CampIndex, owner: int) -> int:
    out[at] = 1.0 if owner == camp else 0.0
    out[at + 1] = 1.0 if owner == 1 - camp else 0.0
    return at + 2


@kernel
def _put_game(out: Rows, at: int, camp: CampIndex, game: GameRecord, points: int) -> int:
    out[at] = bounded((int(game.end_tick) - int(game.tick)) * PER_GAME)
    out[at + 1] = bounded(points * PER_MARGIN)
    out[at + 2] = 1.0 if camp == Camp.BLUE else 0.0
    return at + 3


@kernel
def global_state(
    camp: CampIndex, game: GameRecord, pieces: Pieces, rules: RulesRecord, cells: Cells, state: Rows
) -> None:
    """Write the true state, for the mixer in training only: f4 [Ds], in the camp's frame."""
    state[:] = 0.0
    for side in camp_range(2):
        whose = camp if side == Camp.RED else CampIndex(1 - camp)
        at = int(side) * n_slots(game) * PIECE_WIDTH
        for i in piece_range(first_piece(whose, game), end_piece(whose, game)):
            at = _put_true(state, at, i, camp, game, pieces, cells)
    at = 2 * n_slots(game) * PIECE_WIDTH
    for k in point_range(game.n_points):
        at = _put_owner(state, at, camp, game.point_owner[k])
    _put_game(state, at, camp, game, margin(game, pieces, camp, rules))


@kernel
def _put_true(
    out: Rows, at: int, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, cells: Cells
) -> int:
    piece = pieces[i]
    if piece.blood > 0:
        framed = frame_cell(cells, piece.cell, camp)
        out[at] = 1.0
        out[at + 1] = 0.0 if piece.carrier == NO_PIECE else 1.0
        out[at + 2] = cells[framed].x * PER_CELL - 1.0
        out[at + 3] = cells[framed].y * PER_CELL - 1.0
        out[at + 4] = piece.blood * PER_BLOOD
        out[at + 5] = piece.hidden
        out[at + 6] = piece.suppressed
        out[at + 7] = 1.0 if is_seen(i, game, pieces) else 0.0
        out[at + 8] = ticks_left(piece.cool_ends, game.tick) * PER_TIMER
    return at + PIECE_WIDTH


@kernel
def is_seen(i: PieceIndex, game: GameRecord, pieces: Pieces) -> bool:
    """Some enemy sees the piece."""
    enemy = CampIndex(1 - pieces[i].camp)
    for j in piece_range(first_piece(enemy, game), end_piece(enemy, game)):
        if on_map(pieces[j]) and sees_itself(pieces[j], pieces[i]):
            return True
    return False
