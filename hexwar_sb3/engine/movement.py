"""Movement: hops start, end, wait for room (rule book, sections 4 and 5.6)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.dice import priority
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.pieces import (
    clear_path,
    count_in,
    has_path,
    hop_need,
    hop_progress,
    is_ground,
    next_cell_of,
)
from hexwar_sb3.engine.records import (
    NEVER,
    NO_PIECE,
    GameRecord,
    Log,
    OrderRecord,
    Paths,
    PieceRecord,
    Pieces,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, camp_range, piece_range


@kernel
def begin_move(i: PieceIndex, order: OrderRecord, pieces: Pieces, paths: Paths) -> None:
    """Take up a path: cover is lost, a natural stop transition ends."""
    piece = pieces[i]
    for k in range(int(order.path_len)):
        paths[i, k] = order.path[k]
    piece.path_pos = 0
    piece.path_len = order.path_len
    piece.arrives_at = NEVER
    piece.waiting = 0
    piece.hidden = 0
    piece.stop_ends = NEVER
    piece.stop_forced = 0


@kernel
def begin_stop(piece: PieceRecord, tick: int, rules: RulesRecord) -> None:
    """Turn back in the first half of a hop, else finish it; then stand for the transition."""
    if hop_progress(piece, tick) * 2 >= piece.hop_need and piece.arrives_at != NEVER:
        piece.path_len = piece.path_pos + 1
        piece.stop_pending = 1
        return
    waited = piece.waiting == 1
    clear_path(piece)
    piece.stop_ends = tick + rules.stop_ticks
    piece.stop_forced = 0 if waited else 1


@kernel
def start_hops(
    tick: int, game: GameRecord, pieces: Pieces, paths: Paths, log: Log, rules: RulesRecord, cells: Cells
) -> None:
    """Let every piece with a path and no hop under way start one in the step of `tick`, or wait for room."""
    for i in piece_range(pieces.size):
        piece = pieces[i]
        if piece.blood == 0 or piece.arrives_at != NEVER or not has_path(piece):
            continue
        held = piece.kind == PieceType.SOLDIER and piece.suppressed
        if held or piece.decompress_ends != NEVER:
            piece.waiting = 1
            continue
        need = hop_need(piece, paths[i, piece.path_pos], rules, cells)
        if need == 0:
            clear_path(piece)
            piece.stop_ends = game.tick + rules.stop_ticks
            piece.stop_forced = 0
            note(game, log, Event.PATH_BLOCKED, i, NO_PIECE, piece.cell, 0)
        elif _is_full(piece, next_cell_of(piece, paths[i], cells), pieces, rules):
            piece.waiting = 1
        else:
            piece.waiting = 0
            piece.hop_need = need
            piece.arrives_at = tick + need


@kernel
def _is_full(piece: PieceRecord, cell: CellIndex, pieces: Pieces, rules: RulesRecord) -> bool:
    """No room for one more ground piece of its camp."""
    return is_ground(piece) and count_in(pieces, piece.camp, cell) >= rules.stack_limit


@kernel
def arrive(
    game: GameRecord, pieces: Pieces, paths: Paths, log: Log, rules: RulesRecord, cells: Cells
) -> bool:
    """End the hops due in this step; True if any piece came into a new cell."""
    if not _is_any_ready(game, pieces):
        return False
    entered = False
    for camp in camp_range(2):
        entered |= _arrive_camp(camp, game, pieces, paths, log, rules, cells)
    _wait_outside(game, pieces)
    return entered


@kernel
def _is_ready(piece: PieceRecord, game: GameRecord) -> bool:
    """Its hop is due, and it did not enter yet."""
    return piece.arrives_at <= game.tick + 1


@kernel
def _is_any_ready(game: GameRecord, pieces: Pieces) -> bool:
    for i in piece_range(pieces.size):
        if _is_ready(pieces[i], game):
            return True
    return False


@kernel
def _arrive_camp(
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    paths: Paths,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """Passes over the camp's ready pieces in order of priority until nobody else finds room; True if any did."""
    entered = False
    moved = True
    while moved:
        moved = False
        i = _next_in_order(NO_PIECE, camp, game, pieces)
        while i != NO_PIECE:
            target = next_cell_of(pieces[i], paths[i], cells)
            if not _is_full(pieces[i], target, pieces, rules):
                _enter(i, target, game, pieces, log, rules)
                entered = moved = True
            i = _next_in_order(i, camp, game, pieces)
    return entered


@kernel
def _next_in_order(last: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces) -> PieceIndex:
    """The ready piece of the camp that follows piece `last` in priority; NO_PIECE after the end."""
    best = NO_PIECE
    for i in piece_range(pieces.size):
        if pieces[i].camp != camp or not _is_ready(pieces[i], game) or i == last:
            continue
        rank = priority(game, game.tick, pieces[i])
        if last != NO_PIECE and rank <= priority(game, game.tick, pieces[last]):
            continue
        if best == NO_PIECE or rank < priority(game, game.tick, pieces[best]):
            best = i
    return best


@kernel
def _enter(
    i: PieceIndex, cell: CellIndex, game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord
) -> None:
    piece = pieces[i]
    piece.cell = cell
    piece.arrives_at = NEVER
    piece.arrived_at = game.tick + 1
    piece.came_now = 1
    piece.changed_now = 1
    piece.path_pos += 1
    if piece.passenger != NO_PIECE:
        pieces[piece.passenger].cell = cell
    if not has_path(piece):
        forced = piece.stop_pending
        clear_path(piece)
        piece.stop_ends = game.tick + rules.stop_ticks
        piece.stop_forced = forced
    note(game, log, Event.ARRIVED, i, NO_PIECE, cell, 0)


@kernel
def _wait_outside(game: GameRecord, pieces: Pieces) -> None:
    """Pieces that found no room start their hop again from nothing when there is room."""
    for i in piece_range(pieces.size):
        if _is_ready(pieces[i], game):
            pieces[i].arrives_at = NEVER
            pieces[i].waiting = 1
