"""Task sets G_i (III-A): every task that a piece may be given, by rule.

The order of the rows is the same in both camps' frames: kinds, then spots in their order or
pieces by slot. Row 0 is always stop.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import decompress_code
from hexwar_sb3.engine.pieces import in_fight, is_ground, on_map, weapon_ammo
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, TravelTimes
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import can_hurt, end_piece, first_piece, is_known
from hexwar_sb3.tasks.records import TaskKind, Tasks, TaskSets
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks

_KIND, _TARGET, _CELL, _TICKS = range(4)  # columns of a draft
_SPOT_KINDS = 3  # hold, hide, drop
_PIECE_KINDS = 5  # attack, guide, bombard, shadow; board
_OTHERS = 2  # stop, recover


@kernel
def list_tasks(
    camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord, cells: Cells, eta: TravelTimes, spots: Rows,
    tasks: TaskSets, mask: Rows,
) -> None:  # fmt: skip
    """Write the task sets of a camp.

    Args:
        spots: `spots.load_spots(...)`, [2, S] cells per camp, in the order of the camp's frame.
        tasks: out, [N, K] TASK; row 0 is always stop, the only one of an empty slot.
        mask: out, i1 [N, K], 1 where the row is valid.
    """
    first, end = first_piece(camp, game), end_piece(camp, game)
    draft = np.empty((_OTHERS + _SPOT_KINDS * spots.shape[1] + _PIECE_KINDS * pieces.size, 4), np.int32)
    for n in range(tasks.shape[0]):
        count = _add(draft, 0, TaskKind.STOP, NO_PIECE, NO_CELL, 0)
        if first + n < end and on_map(pieces[PieceIndex(first + n)]):
            count = _list_own(PieceIndex(first + n), game, pieces, rules, draft, count)
            count = _list_spots(PieceIndex(first + n), pieces, rules, cells, eta, spots[camp], draft, count)
            count = _list_targets(
                PieceIndex(first + n), game, pieces, memory, rules, cells, eta, draft, count
            )
            count = _list_carriers(PieceIndex(first + n), game, pieces, rules, cells, eta, draft, count)
        count = shorten(draft, count, tasks.shape[1])
        _write(draft, count, tasks[n], mask[n])


@kernel
def _add(draft: Rows, count: int, kind: int, target: PieceIndex, cell: CellIndex, ticks: int) -> int:
    """Append one row to a draft; the new number of rows."""
    draft[count, _KIND] = kind
    draft[count, _TARGET] = target
    draft[count, _CELL] = cell
    draft[count, _TICKS] = ticks
    return count + 1


@kernel
def _list_own(
    i: PieceIndex, game: GameRecord, pieces: Pieces, rules: RulesRecord, draft: Rows, count: int
) -> int:
    """Recover, only where it is legal now."""
    if decompress_code(pieces[i], game, rules) == Code.OK and not in_fight(game, pieces[i]):
        count = _add(draft, count, TaskKind.RECOVER, NO_PIECE, NO_CELL, 0)
    return count


@kernel
def _list_spots(
    i: PieceIndex,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
    spots: Rows,
    draft: Rows,
    count: int,
) -> int:
    """Hold, hide and drop at every spot that the piece can reach."""
    piece = pieces[i]
    for kind in (TaskKind.HOLD, TaskKind.HIDE, TaskKind.DROP):
        if kind == TaskKind.HIDE and not is_ground(piece):
            continue
        if kind == TaskKind.DROP and piece.passenger == NO_PIECE:
            continue
        for s in range(spots.size):
            ticks = travel_ticks(piece.kind, piece.cell, spots[s], rules, cells, eta)
            if ticks < UNREACHABLE:
                count = _add(draft, count, kind, NO_PIECE, spots[s], ticks)
    return count


@kernel
def has_launcher(i: PieceIndex, game: GameRecord, pieces: Pieces, rules: RulesRecord) -> bool:
    """Some own chariot has a heavy missile that piece i may guide."""
    piece = pieces[i]
    if piece.kind != PieceType.SOLDIER and piece.kind != PieceType.AEROCRAFT:
        return False
    for c in piece_range(first_piece(piece.camp, game), end_piece(piece.camp, game)):
        fits = piece.kind == PieceType.AEROCRAFT or piece.home == c
        if fits and pieces[c].blood > 0 and weapon_ammo(pieces[c], Weapon.HEAVY, rules) > 0:
            return True
    return False


@kernel
def _fits(
    kind: int, i: PieceIndex, j: PieceIndex, launcher: bool, pieces: Pieces, rules: RulesRecord
) -> bool:
    """May piece i have this task against enemy j (architecture.md, table of section 3)?"""
    target = pieces[j].kind
    if kind == TaskKind.ATTACK:
        return can_hurt(pieces[i], target, rules)
    if kind == TaskKind.GUIDE:
        return launcher and (target == PieceType.TANK or target == PieceType.CHARIOT)
    if kind == TaskKind.BOMBARD:
        return target != PieceType.AEROCRAFT and weapon_ammo(pieces[i], Weapon.MORTAR, rules) > 0
    return True


@kernel
def _list_targets(
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
    draft: Rows,
    count: int,
) -> int:
    """Attack, guide, bombard and shadow, for every enemy that is known."""
    piece = pieces[i]
    launcher = has_launcher(i, game, pieces, rules)
    for kind in (TaskKind.ATTACK, TaskKind.GUIDE, TaskKind.BOMBARD, TaskKind.SHADOW):
        for j in piece_range(
            first_piece(CampIndex(1 - piece.camp), game), end_piece(CampIndex(1 - piece.camp), game)
        ):
            known = memory[piece.camp, j]
            if is_known(known) and _fits(kind, i, j, launcher, pieces, rules):
                ticks = travel_ticks(piece.kind, piece.cell, known.cell, rules, cells, eta)
                count = _add(draft, count, kind, j, NO_CELL, ticks)
    return count


@kernel
def _list_carriers(
    i: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
    draft: Rows,
    count: int,
) -> int:
    """Board, for a soldier and every own chariot that is empty."""
    piece = pieces[i]
    if piece.kind != PieceType.SOLDIER:
        return count
    for c in piece_range(first_piece(piece.camp, game), end_piece(piece.camp, game)):
        carrier = pieces[c]
        if carrier.kind == PieceType.CHARIOT and carrier.blood > 0 and carrier.passenger == NO_PIECE:
            ticks = travel_ticks(piece.kind, piece.cell, carrier.cell, rules, cells, eta)
            count = _add(draft, count, TaskKind.BOARD, c, NO_CELL, ticks)
    return count


@kernel
def shorten(draft: Rows, count: int, limit: int) -> int:
    """Drop rows over the limit: shadow rows first, then the farthest by hop time; stop stays."""
    while count > limit:
        worst = _farthest(draft, count, True)
        if worst == 0:
            worst = _farthest(draft, count, False)
        for row in range(worst, count - 1):
            for column in range(draft.shape[1]):
                draft[row, column] = draft[row + 1, column]
        count -= 1
    return count


@kernel
def _farthest(draft: Rows, count: int, shadow: bool) -> int:
    """Row of the farthest task, the last one among equals; 0: none of that kind."""
    worst = 0
    for row in range(1, count):
        if shadow and draft[row, _KIND] != TaskKind.SHADOW:
            continue
        if worst == 0 or draft[row, _TICKS] >= draft[worst, _TICKS]:
            worst = row
    return worst


@kernel
def _write(draft: Rows, count: int, tasks: Tasks, mask: Rows) -> None:
    """Copy a draft into one piece's rows, and clear the rows behind it."""
    for row in range(tasks.size):
        task = tasks[row]
        valid = row < count
        mask[row] = 1 if valid else 0
        task.kind = draft[row, _KIND] if valid else int(TaskKind.STOP)
        task.target = draft[row, _TARGET] if valid else NO_PIECE
        task.cell = draft[row, _CELL] if valid else NO_CELL
