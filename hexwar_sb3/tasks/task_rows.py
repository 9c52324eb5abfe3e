"""The features of every row of a task set, in the order of `features.ROW`."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import get_off_code, get_on_code, indirect_code, point_at
from hexwar_sb3.engine.pieces import has_path, in_fight
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.engine.sight import sees_itself
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart, frame_cell
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.bombard import mortar_value
from hexwar_sb3.tasks.features import (
    BOUND,
    MOST,
    PER_AGE,
    PER_ATTACK,
    PER_CELL,
    PER_COUNT,
    PER_POINT,
    PER_VALUE,
    PER_WAY,
    PER_WORTH,
)
from hexwar_sb3.tasks.known import (
    age,
    armed_level,
    best_level,
    end_piece,
    first_piece,
    would_see,
)
from hexwar_sb3.tasks.records import MissionRecord, Missions, TaskKind, TaskRecord, Tasks
from hexwar_sb3.tasks.shots import best_shot, can_aim, may_guide, may_launch, shot_value
from hexwar_sb3.tasks.travel import travel_ticks

N_TYPES = len(PieceType)
N_TASKS = len(TaskKind)


@kernel
def bounded(value: float) -> float:
    """The number, cut off at BOUND on both sides: for features that a legal scenario can drive beyond it."""
    return max(-BOUND, min(BOUND, value))


@kernel
def put_way(out: Rows, at: int, camp: CampIndex, start: CellIndex, goal: CellIndex, cells: Cells) -> None:
    """dx, dy in the camp's frame, and the distance."""
    a, b = cells[frame_cell(cells, start, camp)], cells[frame_cell(cells, goal, camp)]
    out[at] = (int(b.x) - int(a.x)) * PER_CELL
    out[at + 1] = (int(b.y) - int(a.y)) * PER_CELL
    out[at + 2] = cells_apart(cells, start, goal) * PER_CELL


@kernel
def write_rows(
    i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes,
    tasks: Tasks, mask: Rows, rows: Rows,
) -> None:  # fmt: skip
    """Write the rows of piece i: tasks [K], mask [K] -> rows [K, Dt], 0 behind the last task."""
    piece = pieces[i]
    for k in range(tasks.size):
        out, task = rows[k], tasks[k]
        if mask[k] == 0 and is_blank(out):
            break  # so are the rows behind it: tasks lie together at the front
        out[:] = 0.0
        if mask[k] == 0:
            continue
        out[task.kind] = 1.0
        out[N_TASKS] = 1.0 if is_same(task, missions[i]) else 0.0
        cell = place_of(task, piece, pieces, memory)
        put_way(out, N_TASKS + 1, piece.camp, piece.cell, cell, cells)
        way = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
        out[N_TASKS + 4] = min(way * PER_WAY, MOST)
        out[N_TASKS + 6] = others_on(i, task, game, pieces, missions) * PER_COUNT
        at = _put_place(out, N_TASKS + 7, piece.camp, cell, game, cells)
        if task.target != NO_PIECE and pieces[task.target].camp != piece.camp:
            _put_target(out, at, i, task.target, game, pieces, memory, rules, cells, los)
        now, value = _action(i, task, game, pieces, memory, rules, cells)
        out[N_TASKS + 5] = 1.0 if now else 0.0
        out[at + N_TYPES + 8] = bounded(value * PER_VALUE)


@kernel
def is_blank(row: Rows) -> bool:
    """Nothing was written to the row of a task, which names the kind of its task first."""
    for kind in range(N_TASKS):
        if row[kind] != 0.0:
            return False
    return True


@kernel
def is_same(task: TaskRecord, mission: MissionRecord) -> bool:
    """The mission is to do this very task."""
    return task.kind == mission.kind and task.target == mission.target and task.cell == mission.cell


@kernel
def place_of(task: TaskRecord, piece: PieceRecord, pieces: Pieces, memory: Memory) -> CellIndex:
    """The task's cell, or where its target was last seen, or the piece's own cell."""
    if task.cell != NO_CELL:
        return CellIndex(task.cell)
    if task.target == NO_PIECE:
        return CellIndex(piece.cell)
    if pieces[task.target].camp == piece.camp:
        return CellIndex(pieces[task.target].cell)
    return CellIndex(memory[piece.camp, task.target].cell)


@kernel
def others_on(i: PieceIndex, task: TaskRecord, game: GameRecord, pieces: Pieces, missions: Missions) -> int:
    """Other living pieces of the camp with the same kind of task and the same target or cell."""
    if task.target == NO_PIECE and task.cell == NO_CELL:
        return 0
    count = 0
    camp = pieces[i].camp
    for k in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if k != i and pieces[k].blood > 0 and is_same(task, missions[k]):
            count += 1
    return count


@kernel
def _put_place(out: Rows, at: int, camp: CampIndex, cell: CellIndex, game: GameRecord, cells: Cells) -> int:
    point = point_at(cell, game)
    if point >= 0:
        out[at] = game.point_value[point] * PER_POINT
        out[at + 1] = 1.0 if game.point_owner[point] == camp else 0.0
        out[at + 2] = 1.0 if game.point_owner[point] == 1 - camp else 0.0
    out[at + 3] = cells[cell].concealed
    out[at + 4] = cells[cell].exposure
    return at + 5


@kernel
def _put_target(
    out: Rows, at: int, i: PieceIndex, j: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord, cells: Cells,
    los: Sightlines,
) -> None:  # fmt: skip
    """An enemy as the camp knows it; the column of the action's value is left out."""
    piece, kind = pieces[i], pieces[j].kind
    known = memory[piece.camp, j]
    out[at + kind] = 1.0
    at += N_TYPES
    out[at] = rules.value[kind] * int(known.blood) * PER_WORTH
    out[at + 1] = min(age(known, game.tick) * PER_AGE, MOST)
    out[at + 2] = known.seen
    out[at + 3] = 1.0 if sees_itself(piece, pieces[j]) else 0.0
    out[at + 4] = known.hidden
    out[at + 5] = known.suppressed
    out[at + 6] = known.moving
    if would_see(piece.kind, piece.cell, kind, known, rules, cells, los):
        out[at + 7] = armed_level(piece, piece.cell, kind, known.cell, rules, cells) * PER_ATTACK
    threat = best_level(kind, known.blood, known.cell, piece.kind, piece.cell, rules, cells)
    out[at + 9] = threat * PER_ATTACK


@kernel
def _action(
    i: PieceIndex,
    task: TaskRecord,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> tuple[bool, float]:
    """Whether the task's action is legal from here and now, and what it is worth in points."""
    piece = pieces[i]
    kind, j = task.kind, task.target
    free = not in_fight(game, piece)
    if kind == TaskKind.ATTACK:
        return _direct(i, j, game, pieces, memory, rules, cells)
    if kind == TaskKind.GUIDE:
        return _guided(i, j, game, pieces, memory, rules, cells)
    if kind == TaskKind.BOMBARD:
        known = memory[piece.camp, j]
        value = mortar_value(i, known.cell, known.seen == 1, game, pieces, memory, rules, cells)
        return free and indirect_code(piece, known.cell, rules, cells) == Code.OK, value
    if kind == TaskKind.SHADOW:
        return sees_itself(piece, pieces[j]), 0.0
    if kind == TaskKind.BOARD:
        return free and get_on_code(piece, j, pieces) == Code.OK, 0.0
    if kind == TaskKind.DROP and task.cell == piece.cell:
        return free and get_off_code(i, piece.passenger, pieces, rules) == Code.OK, 0.0
    if kind == TaskKind.STOP:
        return has_path(piece), 0.0
    return task.cell == NO_CELL or task.cell == piece.cell, 0.0


@kernel
def _direct(
    i: PieceIndex,
    j: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> tuple[bool, float]:
    if not sees_itself(pieces[i], pieces[j]):
        return False, 0.0
    allotted = np.zeros(pieces.size, np.int64)
    now, _, _ = best_shot(i, j, False, allotted, game, pieces, memory, rules, cells)
    settled, _, _ = best_shot(i, j, True, allotted, game, pieces, memory, rules, cells)
    return now > 0.0, settled


@kernel
def _guided(
    i: PieceIndex,
    j: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> tuple[bool, float]:
    if not can_aim(i, j, game, pieces):
        return False, 0.0
    allotted = np.zeros(pieces.size, np.int64)
    ready = may_guide(i, game, pieces)
    now, best = False, 0.0
    for c in piece_range(first_piece(pieces[i].camp, game), end_piece(pieces[i].camp, game)):
        if may_launch(i, c, game, pieces, rules):
            value = shot_value(c, j, Weapon.HEAVY, True, allotted, game, pieces, memory, rules, cells)
            now = now or (ready and value > 0.0)
            best = max(best, value)
    return now, best
