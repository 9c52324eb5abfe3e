"""Line of sight, visibility and what each camp remembers (rule book, section 6)."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.pieces import in_motion, next_cell_of, on_map
from hexwar_sb3.engine.records import (
    NO_CELL,
    NO_PIECE,
    GameRecord,
    Memory,
    MemoryRecord,
    Paths,
    PieceRecord,
    Pieces,
)
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.maps.sightlines import line_of_sight
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, camp_range, piece_range

_ONE = np.uint64(1)


@kernel
def has_line(
    kind: int, cell: CellIndex, target_kind: int, target_cell: CellIndex, cells: Cells, los: Sightlines
) -> bool:
    """Line of sight between two types of pieces in two cells: it depends on who is airborne."""
    if kind == PieceType.AEROCRAFT:
        return line_of_sight(los, 2 if target_kind == PieceType.AEROCRAFT else 1, cell, target_cell, cells)
    if target_kind == PieceType.AEROCRAFT:
        return line_of_sight(los, 1, target_cell, cell, cells)
    return line_of_sight(los, 0, cell, target_cell, cells)


@kernel
def sight_cells(observer: PieceRecord, target: PieceRecord, rules: RulesRecord, cells: Cells) -> int:
    """Greatest distance at which the observer sees the target, line of sight given."""
    reach = int(rules.sight[observer.kind, target.kind])
    airborne = observer.kind == PieceType.AEROCRAFT
    if target.hidden:
        lower = airborne or cells[target.cell].elev_m < cells[observer.cell].elev_m
        if target.kind == PieceType.SOLDIER or not lower:
            reach = max(1, reach // rules.hidden_sight_divisor)
    if cells[target.cell].concealed and target.kind != PieceType.AEROCRAFT:
        reach = max(1, reach // rules.concealed_sight_divisor)
    return reach


@kernel
def sees(
    observer: PieceRecord, target: PieceRecord, rules: RulesRecord, cells: Cells, los: Sightlines
) -> bool:
    """Does one piece see one enemy piece?"""
    if not on_map(observer) or not on_map(target):
        return False
    if cells_apart(cells, observer.cell, target.cell) > sight_cells(observer, target, rules, cells):
        return False
    return has_line(observer.kind, observer.cell, target.kind, target.cell, cells, los)


@kernel
def look(
    i: PieceIndex, j: PieceIndex, pieces: Pieces, rules: RulesRecord, cells: Cells, los: Sightlines
) -> None:
    """Renew the bit "i sees j"."""
    bit = _ONE << np.uint64(pieces[j].slot)
    if sees(pieces[i], pieces[j], rules, cells, los):
        pieces[i].sees |= bit
    else:
        pieces[i].sees &= ~bit


@kernel
def is_covered(piece: PieceRecord) -> bool:
    """Hidden or aboard: what changes who sees it where it stands."""
    return piece.hidden == 1 or piece.carrier != NO_PIECE


@kernel
def look_around(pieces: Pieces, rules: RulesRecord, cells: Cells, los: Sightlines) -> None:
    """Renew what every changed piece sees and who sees it (incremental visibility)."""
    for i in piece_range(pieces.size):
        if pieces[i].changed_now or pieces[i].covered_now != is_covered(pieces[i]):
            for j in piece_range(pieces.size):
                if pieces[j].camp != pieces[i].camp:
                    look(i, j, pieces, rules, cells, los)
                    look(j, i, pieces, rules, cells, los)
    for i in piece_range(pieces.size):
        pieces[i].covered_now = 0
        pieces[i].changed_now = 0


@kernel
def look_all(pieces: Pieces, rules: RulesRecord, cells: Cells, los: Sightlines) -> None:
    """Renew every pair: the oracle of the incremental form, and the first look of a game."""
    for i in piece_range(pieces.size):
        pieces[i].sees = np.uint64(0)
        pieces[i].covered_now = 0
        pieces[i].changed_now = 0
        for j in piece_range(pieces.size):
            if pieces[j].camp != pieces[i].camp:
                look(i, j, pieces, rules, cells, los)


@kernel
def sees_itself(piece: PieceRecord, enemy: PieceRecord) -> bool:
    """The piece itself sees an enemy now."""
    return (piece.sees >> np.uint64(enemy.slot)) & _ONE == _ONE


@kernel
def remember(game: GameRecord, pieces: Pieces, memory: Memory, paths: Paths, cells: Cells) -> None:
    """Bring both camps' memories up to the state of game.tick."""
    for camp in camp_range(2):
        union = np.uint64(0)
        for i in piece_range(pieces.size):
            if pieces[i].camp == camp:
                union |= pieces[i].sees
        for j in piece_range(pieces.size):
            if pieces[j].camp == camp:
                continue
            lit = game.fog == 0 and on_map(pieces[j])
            if lit or (union >> np.uint64(pieces[j].slot)) & _ONE == _ONE:
                _keep_seen(game, camp, pieces[j], memory[camp, j], paths[j], cells)
            elif memory[camp, j].seen:
                _lose_sight(game, pieces[j], memory[camp, j])


@kernel
def _keep_seen(
    game: GameRecord, camp: CampIndex, piece: PieceRecord, known: MemoryRecord, path: Rows, cells: Cells
) -> None:
    if known.seen == 0:
        known.seen = 1
        known.tick = game.tick
        known.first_tick = game.tick
        known.still_since = game.tick
        game.contact_tick[camp] = game.tick
    elif known.cell != piece.cell:
        known.still_since = game.tick
    known.cell = piece.cell
    known.next_cell = next_cell_of(piece, path, cells)
    known.blood = piece.blood
    known.hidden = piece.hidden
    known.suppressed = piece.suppressed
    known.moving = 1 if in_motion(piece) else 0


@kernel
def _lose_sight(game: GameRecord, piece: PieceRecord, known: MemoryRecord) -> None:
    """Last seen in the state before this one; a death that was watched is known."""
    known.seen = 0
    known.next_cell = NO_CELL
    known.tick = game.tick - 1
    if piece.blood == 0:
        known.blood = 0
        known.tick = game.tick
