"""Whether a camp can notice anything new: nobody acts on what he cannot know, or twice on the same."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.records import GameRecord, Memory, MemoryRecord, PieceRecord, Pieces, Rounds
from hexwar_sb3.kernels import kernel
from hexwar_sb3.play.records import DriveRecord
from hexwar_sb3.rules.indices import CampIndex, piece_range, point_range
from hexwar_sb3.tasks.known import end_piece, first_piece

_BITS = (1 << 62) - 1
_STRIDE = 0x2545F4914F6CDD1D  # any large odd number: its powers tell the fields apart
_KEYS = tuple(pow(_STRIDE, k, _BITS + 1) for k in range(1, 17))
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)


@kernel
def has_news(
    camp: CampIndex, drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds
) -> bool:
    """Something that the camp knows has changed since it was last asked; remembers the present."""
    known = fingerprint(camp, game, pieces, memory, rounds)
    changed = known != drive.known[camp]
    drive.known[camp] = known
    return changed


@kernel
def fingerprint(camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds) -> int:
    """A number for all that the camp's orders may depend on, the clock apart."""
    known = 1
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        known = fold(known, own_key(pieces[i]))
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = fold(known, enemy_key(memory[camp, j]))
    for k in point_range(game.n_points):
        known = fold(known, int(game.point_owner[k]))
    for r in range(rounds.size):
        if pieces[rounds[r].owner].camp == camp:
            known = fold(known, int(rounds[r].status))
    return known


@kernel
def fold(known: int, key: int) -> int:
    """Mix one more number into a fingerprint."""
    return (known * _STRIDE + key) & _BITS


@kernel
def own_key(piece: PieceRecord) -> int:
    """A number for an own piece: place, movement, timers, health, sight."""
    timers = (
        int(piece.arrives_at) * _KEYS[0] + int(piece.stop_ends) * _KEYS[1] + int(piece.hide_ends) * _KEYS[2]
    )
    timers += int(piece.board_ends) * _KEYS[3] + int(piece.decompress_ends) * _KEYS[4]
    timers += (
        int(piece.cool_ends) * _KEYS[5] + int(piece.mortar_ends) * _KEYS[6] + int(piece.keep_ends) * _KEYS[7]
    )
    path = int(piece.path_pos) * _KEYS[8] + int(piece.path_len) * _KEYS[9]
    flags = (
        int(piece.hidden) + 2 * int(piece.suppressed) + 4 * int(piece.waiting) + 8 * int(piece.stop_pending)
    )
    health = int(piece.blood) * _KEYS[10] + flags * _KEYS[11] + int(piece.carrier) * _KEYS[12]
    sight = int(np.int64(piece.sees & _LOW)) * _KEYS[14] + int(np.int64(piece.sees >> _HALF)) * _KEYS[15]
    return (timers + path + health + int(piece.cell) * _KEYS[13] + sight) & _BITS


@kernel
def enemy_key(enemy: MemoryRecord) -> int:
    """A number for what is remembered of an enemy, but for the ticks."""
    flags = int(enemy.hidden) + 2 * int(enemy.suppressed) + 4 * int(enemy.moving) + 8 * int(enemy.seen)
    place = int(enemy.cell) * _KEYS[0] + int(enemy.next_cell) * _KEYS[1]
    return (place + int(enemy.blood) * _KEYS[2] + flags * _KEYS[3]) & _BITS
