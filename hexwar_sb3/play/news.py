"""Whether a camp can notice anything new: nobody acts on what he cannot know, or twice on the same."""

from __future__ import annotations

from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.tasks.known import end_piece, first_piece

_STRIDE = 4_194_301  # a prime; with _BITS no product leaves 64 bits
_BITS = (1 << 40) - 1


@kernel
def has_news(camp: int, drive: Row, game: Row, pieces: Rows, memory: Rows, rounds: Rows) -> bool:
    """Something that the camp knows has changed since it was last asked; remembers the present."""
    known = fingerprint(camp, game, pieces, memory, rounds)
    changed = known != drive.known[camp]
    drive.known[camp] = known
    return changed


@kernel
def fingerprint(camp: int, game: Row, pieces: Rows, memory: Rows, rounds: Rows) -> int:
    """A number for all that the camp's orders may depend on, the clock apart."""
    known = 1
    for i in range(first_piece(camp, game), end_piece(camp, game)):
        known = fold_own(known, pieces[i])
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        known = fold_enemy(known, memory[camp, j])
    for k in range(game.n_points):
        known = fold(known, game.point_owner[k], 0)
    for r in range(rounds.size):
        if pieces[rounds[r].owner].camp == camp:
            known = fold(known, rounds[r].status, 0)
    return known


@kernel
def fold(known: int, a: int, b: int) -> int:
    """Mix two numbers of 16 bits into a fingerprint."""
    return (known * _STRIDE + (int(a) << 16) + int(b)) & _BITS


@kernel
def fold_own(known: int, piece: Row) -> int:
    """Mix in an own piece: place, movement, timers, health, sight."""
    known = fold(known, piece.cell, piece.arrives_at)
    known = fold(known, piece.stop_ends, piece.hide_ends)
    known = fold(known, piece.board_ends, piece.decompress_ends)
    known = fold(known, piece.cool_ends, piece.mortar_ends)
    known = fold(known, piece.keep_ends, (int(piece.path_pos) << 7) + int(piece.path_len))
    flags = (
        int(piece.hidden) + 2 * int(piece.suppressed) + 4 * int(piece.waiting) + 8 * int(piece.stop_pending)
    )
    known = fold(known, (int(piece.blood) << 4) + flags, piece.carrier)
    return fold(known, int(piece.sees) >> 16, int(piece.sees) & 0xFFFF)


@kernel
def fold_enemy(known: int, enemy: Row) -> int:
    """Mix in what is remembered of an enemy, but for the ticks."""
    flags = int(enemy.hidden) + 2 * int(enemy.suppressed) + 4 * int(enemy.moving) + 8 * int(enemy.seen)
    known = fold(known, enemy.cell, enemy.next_cell)
    return fold(known, enemy.blood, flags)
