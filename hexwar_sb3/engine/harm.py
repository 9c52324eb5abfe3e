"""What fire does to pieces: losses, suppression, death (rule book, sections 5.4, 7, 13)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.pieces import cancel_transitions, clear_boarding, clear_path, has_path, hop_progress
from hexwar_sb3.engine.records import NEVER, NO_PIECE, GameRecord, Log, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import PieceIndex, piece_range


@kernel
def apply_results(game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord) -> None:
    """Apply all collected results together."""
    for i in piece_range(pieces.size):
        if pieces[i].hit_now:
            _suffer(i, game, pieces, log, rules)
            pieces[i].hit_now = 0
            pieces[i].zero_now = 0
            pieces[i].losses_now = 0


@kernel
def _suffer(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord) -> None:
    piece = pieces[i]
    losses = int(piece.losses_now)
    before = piece.suppressed and piece.keep_ends < game.tick + rules.keep_ticks  # not in this step
    if piece.kind == PieceType.SOLDIER and before and piece.zero_now:
        losses += 1
    losses = min(losses, int(piece.blood))
    if losses > 0:
        piece.blood -= losses
        game.loss_tick[piece.camp] = game.tick + 1
        note(game, log, Event.LOSS, i, NO_PIECE, piece.cell, losses)
    if piece.blood == 0:
        die_with_passenger(i, game, pieces, log)
        return
    if piece.kind != PieceType.AEROCRAFT:
        _suppress(i, game, pieces, log, rules)
    _hurt_passenger(i, losses, game, pieces, log)


@kernel
def _suppress(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord) -> None:
    piece = pieces[i]
    piece.suppressed = 1
    piece.keep_ends = game.tick + rules.keep_ticks
    cancel_transitions(i, pieces)
    if piece.kind == PieceType.SOLDIER and has_path(piece) and hop_progress(piece, game.tick) == 0:
        piece.arrives_at = NEVER
        piece.waiting = 1
    note(game, log, Event.SUPPRESSED, i, NO_PIECE, piece.cell, 0)


@kernel
def _hurt_passenger(i: PieceIndex, losses: int, game: GameRecord, pieces: Pieces, log: Log) -> None:
    """A chariot that loses n vehicles costs its passenger min(n, squads) (section 13)."""
    p = pieces[i].passenger
    if p == NO_PIECE or losses == 0:
        return
    losses = min(losses, int(pieces[p].blood))
    pieces[p].blood -= losses
    note(game, log, Event.LOSS, p, i, pieces[i].cell, losses)
    if pieces[p].blood > 0:
        return
    pieces[i].passenger = NO_PIECE
    cancel_transitions(i, pieces)
    _die(p, game, pieces, log)


@kernel
def die_with_passenger(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log) -> None:
    """Destroy a piece and whoever rides in it."""
    p = pieces[i].passenger
    _die(i, game, pieces, log)
    if p != NO_PIECE:
        _die(p, game, pieces, log)


@kernel
def _die(i: PieceIndex, game: GameRecord, pieces: Pieces, log: Log) -> None:
    piece = pieces[i]
    cancel_transitions(i, pieces)
    clear_boarding(piece)
    clear_path(piece)
    piece.blood = 0
    piece.hidden = 0
    piece.suppressed = 0
    piece.stop_ends = NEVER
    piece.stop_forced = 0
    piece.cool_ends = NEVER
    piece.mortar_ends = NEVER
    piece.keep_ends = NEVER
    piece.passenger = NO_PIECE
    piece.carrier = NO_PIECE
    piece.changed_now = 1
    note(game, log, Event.DEAD, i, NO_PIECE, piece.cell, 0)
