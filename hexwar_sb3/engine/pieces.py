"""What can be said of one piece by looking at its record (rule book, section 3)."""

from __future__ import annotations

from hexwar_sb3.engine.records import BOARD_NONE, NEVER, NO_CELL, NO_PIECE, GameRecord, PieceRecord, Pieces
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import NO_POOL, RulesRecord
from hexwar_sb3.rules.enums import HopClass, PieceType, TargetClass
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range


@kernel
def has_path(piece: PieceRecord) -> bool:
    """The piece has cells left to walk."""
    return piece.path_pos < piece.path_len


@kernel
def in_motion(piece: PieceRecord) -> bool:
    """What the fire modifiers call moving: a path, or the stop transition after it."""
    return has_path(piece) or piece.stop_ends != NEVER


@kernel
def is_busy(piece: PieceRecord) -> bool:
    """Hiding, boarding, decompressing or in a forced stop: no order but occupy."""
    if piece.hide_ends != NEVER or piece.board_ends != NEVER or piece.decompress_ends != NEVER:
        return True
    return piece.stop_forced == 1 and piece.stop_ends != NEVER


@kernel
def is_settled(piece: PieceRecord) -> bool:
    """Stands, with no transition of any kind under way."""
    if has_path(piece) or piece.stop_ends != NEVER:
        return False
    return piece.hide_ends == NEVER and piece.board_ends == NEVER and piece.decompress_ends == NEVER


@kernel
def is_ground(piece: PieceRecord) -> bool:
    """Everything but an aerocraft."""
    return piece.kind != PieceType.AEROCRAFT


@kernel
def on_map(piece: PieceRecord) -> bool:
    """Alive and not aboard."""
    return piece.blood > 0 and piece.carrier == NO_PIECE


@kernel
def stands_in(piece: PieceRecord, cell: CellIndex) -> bool:
    """A living ground piece, not aboard, in this cell (progress counts for the old cell)."""
    return piece.cell == cell and piece.blood > 0 and piece.carrier == NO_PIECE and is_ground(piece)


@kernel
def count_in(pieces: Pieces, camp: CampIndex, cell: CellIndex) -> int:
    """Ground pieces of a camp that stand in a cell; passengers do not count."""
    count = 0
    for i in piece_range(pieces.size):
        if pieces[i].camp == camp and stands_in(pieces[i], cell):
            count += 1
    return count


@kernel
def in_fight(game: GameRecord, piece: PieceRecord) -> bool:
    """In close combat: a ground piece in a cell that holds both camps (section 10)."""
    if not is_ground(piece) or piece.carrier != NO_PIECE:
        return False
    for f in range(game.n_fights):
        if game.fight_cell[f] == piece.cell:
            return True
    return False


@kernel
def target_class(kind: int) -> int:
    """Column of the attack tables for a type of piece."""
    if kind == PieceType.SOLDIER:
        return int(TargetClass.SOLDIER)
    if kind == PieceType.AEROCRAFT:
        return int(TargetClass.AEROCRAFT)
    return int(TargetClass.VEHICLE)


@kernel
def weapon_ammo(piece: PieceRecord, weapon: int, rules: RulesRecord) -> int:
    """Rounds left for a weapon; 0 also where the type does not carry it."""
    pool = rules.pool[piece.kind, weapon]
    if pool == NO_POOL:
        return 0
    return int(piece.ammo[pool])


@kernel
def spend_round(piece: PieceRecord, weapon: int, rules: RulesRecord) -> None:
    """One round less in the weapon's pool."""
    piece.ammo[rules.pool[piece.kind, weapon]] -= 1


@kernel
def hop_need(piece: PieceRecord, direction: int, rules: RulesRecord, cells: Cells) -> int:
    """Ticks of a hop from the piece's cell, 0 where there is none."""
    return hop_from(piece.kind, piece.cell, direction, rules, cells)


@kernel
def hop_from(kind: int, cell: CellIndex, direction: int, rules: RulesRecord, cells: Cells) -> int:
    """Ticks of a hop of a type of piece from a cell, 0 where there is none (section 1)."""
    if cells[cell].neighbour[direction] == NO_CELL:
        return 0
    if kind == PieceType.AEROCRAFT:
        return int(rules.base_hop[kind])
    hop_class = HopClass.SOLDIER if kind == PieceType.SOLDIER else HopClass.VEHICLE
    return int(cells[cell].hop_ticks[hop_class, direction])


@kernel
def hop_progress(piece: PieceRecord, tick: int) -> int:
    """Ticks of the hop under way that are done in the state of `tick`; 0 without a hop."""
    if piece.arrives_at == NEVER:
        return 0
    return int(piece.hop_need) - (int(piece.arrives_at) - tick)


@kernel
def next_cell_of(piece: PieceRecord, path: Rows, cells: Cells) -> CellIndex:
    """Cell that the path leads to next; NO_CELL without a path."""
    if not has_path(piece):
        return NO_CELL
    return CellIndex(cells[piece.cell].neighbour[path[piece.path_pos]])


@kernel
def clear_path(piece: PieceRecord) -> None:
    """Drop the path and the hop under way: the piece stands in its cell."""
    piece.path_pos = 0
    piece.path_len = 0
    piece.arrives_at = NEVER
    piece.waiting = 0
    piece.stop_pending = 0


@kernel
def clear_boarding(piece: PieceRecord) -> None:
    """Forget a boarding under way (one side of it)."""
    piece.board_ends = NEVER
    piece.board_kind = BOARD_NONE
    piece.board_partner = NO_PIECE


@kernel
def cancel_boarding(i: PieceIndex, pieces: Pieces) -> None:
    """Cancel the boarding of piece i for both partners."""
    if pieces[i].board_kind == BOARD_NONE:
        return
    partner = pieces[i].board_partner
    clear_boarding(pieces[i])
    clear_boarding(pieces[partner])


@kernel
def cancel_transitions(i: PieceIndex, pieces: Pieces) -> None:
    """Suppression, close combat: hiding, boarding and decompressing end without effect."""
    pieces[i].hide_ends = NEVER
    pieces[i].decompress_ends = NEVER
    cancel_boarding(i, pieces)
