"""What a camp may know of the enemy, and small questions about its own pieces.

An enemy is read through `memory[camp]` only: nothing here depends on what the camp can neither
see nor remember (rule book, section 6).
"""

from __future__ import annotations

from hexwar_sb3.engine.fire import height_correction
from hexwar_sb3.engine.pieces import target_class
from hexwar_sb3.engine.records import NEVER, NO_CELL, GameRecord, Memory, MemoryRecord, PieceRecord, Pieces
from hexwar_sb3.engine.sight import has_line
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import NO_POOL, RulesRecord
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range


@kernel
def first_piece(camp: CampIndex, game: GameRecord) -> PieceIndex:
    """Index of a camp's first piece."""
    return PieceIndex(0 if camp == Camp.RED else game.n_red)


@kernel
def end_piece(camp: CampIndex, game: GameRecord) -> PieceIndex:
    """Index behind a camp's last piece."""
    return PieceIndex(game.n_red if camp == Camp.RED else game.n_pieces)


@kernel
def n_slots(game: GameRecord) -> int:
    """Slots of either camp: pieces of the larger one."""
    return int(max(game.n_red, game.n_pieces - game.n_red))


@kernel
def ticks_left(ends: int, tick: int) -> int:
    """The view of an end tick as a counter: 0 when it does not run."""
    if ends == NEVER or ends <= tick:
        return 0
    return int(ends) - int(tick)


@kernel
def is_known(known: MemoryRecord) -> bool:
    """Seen at least once, and not known to be destroyed."""
    return known.cell != NO_CELL and known.blood > 0


@kernel
def age(known: MemoryRecord, tick: int) -> int:
    """Ticks since an enemy was last seen."""
    return 0 if known.seen else int(tick) - int(known.tick)


@kernel
def reach_of_sight(
    kind: int, cell: CellIndex, target_kind: int, known: MemoryRecord, rules: RulesRecord, cells: Cells
) -> int:
    """Greatest distance at which a type of piece in `cell` would see a known enemy (section 6)."""
    reach = int(rules.sight[kind, target_kind])
    if known.hidden:
        lower = kind == PieceType.AEROCRAFT or cells[known.cell].elev_m < cells[cell].elev_m
        if target_kind == PieceType.SOLDIER or not lower:
            reach = max(1, reach // int(rules.hidden_sight_divisor))
    if cells[known.cell].concealed and target_kind != PieceType.AEROCRAFT:
        reach = max(1, reach // int(rules.concealed_sight_divisor))
    return reach


@kernel
def would_see(
    kind: int,
    cell: CellIndex,
    target_kind: int,
    known: MemoryRecord,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
) -> bool:
    """Whether a type of piece in `cell` would see the enemy where it was last seen."""
    apart = cells_apart(cells, cell, known.cell)
    if apart > reach_of_sight(kind, cell, target_kind, known, rules, cells):
        return False
    return has_line(kind, cell, target_kind, known.cell, cells, los)


@kernel
def level_from(
    weapon: int,
    kind: int,
    blood: int,
    cell: CellIndex,
    target_kind: int,
    target_cell: CellIndex,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Attack level between two cells, height corrected; 0: no shot (section 7)."""
    apart = cells_apart(cells, cell, target_cell)
    if apart >= rules.level.shape[3]:
        return 0
    level = int(rules.level[weapon, target_class(target_kind), blood, apart])
    if level == 0 or kind == PieceType.AEROCRAFT or target_kind == PieceType.AEROCRAFT:
        return level
    uphill = int(cells[target_cell].level) - int(cells[cell].level)
    return max(0, level + height_correction(uphill, apart, rules))


@kernel
def best_level(
    kind: int,
    blood: int,
    cell: CellIndex,
    target_kind: int,
    target_cell: CellIndex,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Highest attack level of any weapon of a type of piece, ammunition aside."""
    best = 0
    for weapon in range(rules.pool.shape[1]):
        if rules.pool[kind, weapon] != NO_POOL:
            level = level_from(weapon, kind, blood, cell, target_kind, target_cell, rules, cells)
            best = max(best, level)
    return best


@kernel
def armed_level(
    piece: PieceRecord,
    cell: CellIndex,
    target_kind: int,
    target_cell: CellIndex,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Highest attack level of the weapons that the piece still has rounds for, fired from `cell`."""
    best = 0
    for weapon in range(rules.pool.shape[1]):
        pool = rules.pool[piece.kind, weapon]
        if pool != NO_POOL and piece.ammo[pool] > 0:
            level = level_from(weapon, piece.kind, piece.blood, cell, target_kind, target_cell, rules, cells)
            best = max(best, level)
    return best


@kernel
def can_hurt(piece: PieceRecord, target_kind: int, rules: RulesRecord) -> bool:
    """Some weapon of the piece, with rounds left, has a level against the type at some distance."""
    target = target_class(target_kind)
    for weapon in range(rules.pool.shape[1]):
        pool = rules.pool[piece.kind, weapon]
        if pool == NO_POOL or piece.ammo[pool] == 0:
            continue
        for apart in range(rules.level.shape[3]):
            if rules.level[weapon, target, piece.blood, apart] > 0:
                return True
    return False


@kernel
def known_in(camp: CampIndex, cell: CellIndex, game: GameRecord, pieces: Pieces, memory: Memory) -> int:
    """Enemy ground pieces that the camp sees in a cell."""
    count = 0
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        if known.seen and known.cell == cell and known.blood > 0 and pieces[j].kind != PieceType.AEROCRAFT:
            count += 1
    return count


@kernel
def known_in_zone(
    camp: CampIndex, cell: CellIndex, game: GameRecord, pieces: Pieces, memory: Memory, cells: Cells
) -> int:
    """Enemy ground pieces that the camp sees in a cell or beside it: who keeps it from occupying."""
    count = 0
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        there = known.seen and known.blood > 0 and pieces[j].kind != PieceType.AEROCRAFT
        if there and cells_apart(cells, cell, known.cell) <= 1:
            count += 1
    return count
