"""What ends with a step: cool-downs, transitions, suppression, boarding, bursts (section 5.8)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.pieces import cancel_boarding, count_in
from hexwar_sb3.engine.records import (
    BOARD_OFF,
    BOARD_ON,
    NEVER,
    NO_PIECE,
    ROUND_BURSTING,
    ROUND_FREE,
    GameRecord,
    Log,
    PieceRecord,
    Pieces,
    Rounds,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import PieceIndex, piece_range


@kernel
def end_timers(game: GameRecord, pieces: Pieces, rounds: Rounds, log: Log, rules: RulesRecord) -> bool:
    """Timers that end with this step take effect; True if a soldier got off."""
    now = game.tick + 1
    got_off = False
    for i in piece_range(pieces.size):
        piece = pieces[i]
        if piece.cool_ends <= now:
            piece.cool_ends = NEVER
        if piece.mortar_ends <= now:
            piece.mortar_ends = NEVER
        if piece.stop_ends <= now:
            piece.stop_ends = NEVER
            piece.stop_forced = 0
        if piece.hide_ends <= now:
            piece.hide_ends = NEVER
            piece.hidden = 1
            note(game, log, Event.HIDDEN, i, NO_PIECE, piece.cell, 0)
        if piece.keep_ends <= now or piece.decompress_ends <= now:
            release(piece)
            note(game, log, Event.RELEASED, i, NO_PIECE, piece.cell, 0)
        if piece.board_ends <= now and piece.board_kind == BOARD_ON:
            end_get_on(i, game, pieces, log)
        elif piece.board_ends <= now and piece.board_kind == BOARD_OFF:
            got_off |= end_get_off(i, game, pieces, log, rules)
    for r in range(rounds.size):
        if rounds[r].status == ROUND_BURSTING and rounds[r].end_at <= now:
            rounds[r].status = ROUND_FREE
    return got_off


@kernel
def release(piece: PieceRecord) -> None:
    """Suppression ends, by itself or by decompressing."""
    piece.suppressed = 0
    piece.keep_ends = NEVER
    piece.decompress_ends = NEVER


@kernel
def end_get_on(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log) -> None:
    """The soldier is aboard (called for whichever partner comes first)."""
    partner = PieceIndex(pieces[i].board_partner)
    soldier, chariot = (i, partner) if pieces[i].kind == PieceType.SOLDIER else (partner, i)
    cancel_boarding(i, pieces)
    pieces[soldier].carrier = chariot
    pieces[chariot].passenger = soldier
    note(game, log, Event.ABOARD, soldier, chariot, pieces[chariot].cell, 0)


@kernel
def end_get_off(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord) -> bool:
    """The soldier stands in the cell, or waits aboard where the cell filled up meanwhile."""
    partner = PieceIndex(pieces[i].board_partner)
    soldier, chariot = (i, partner) if pieces[i].carrier != NO_PIECE else (partner, i)
    cancel_boarding(i, pieces)
    cell = pieces[chariot].cell
    if count_in(pieces, pieces[chariot].camp, cell) >= rules.stack_limit:
        note(game, log, Event.GETOFF_BLOCKED, soldier, chariot, cell, 0)
        return False
    pieces[soldier].carrier = NO_PIECE
    pieces[soldier].cell = cell
    pieces[soldier].arrived_at = game.tick + 1
    pieces[chariot].passenger = NO_PIECE
    note(game, log, Event.OFF, soldier, chariot, cell, 0)
    pieces[soldier].came_now = 1
    pieces[soldier].changed_now = 1
    return True
