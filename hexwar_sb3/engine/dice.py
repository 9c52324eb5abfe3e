"""Counter-based dice (rule book, section 11): no order of calls, no hidden state.

Every number is a hash of the game's seed and of what it is thrown for, so that the same game
alone, in a batch, in another process or re-played is the same game to the bit.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.records import GameRecord, PieceRecord
from hexwar_sb3.kernels import Row, kernel
from hexwar_sb3.rules.enums import Dice

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S27, _S30, _S31, _S32 = np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(32)
_FACES = np.uint64(6)


@kernel
def splitmix64(x: np.uint64) -> np.uint64:
    """Finaliser of the splitmix64 generator."""
    z = x + _GOLDEN
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@kernel
def identity(game: GameRecord, piece: PieceRecord) -> np.uint64:
    """Colour-neutral id of a piece: its slot under the salt of its camp."""
    return splitmix64(game.salt[piece.camp] + np.uint64(piece.slot))


@kernel
def throw(game: GameRecord, tick: int, kind: int, a: Row, b: Row, draw: int) -> np.uint64:
    """64 random bits for one purpose: kind (Dice), actor a, target b, number of the draw."""
    purpose = np.uint64((int(tick) * 128 + int(kind)) * 8 + int(draw))
    x = splitmix64(purpose) ^ identity(game, a)
    x = splitmix64(x) ^ identity(game, b)
    return splitmix64(game.seed ^ splitmix64(x))


@kernel
def die(game: GameRecord, tick: int, kind: int, a: Row, b: Row, draw: int) -> int:
    """One die, 1..6."""
    high = throw(game, tick, kind, a, b, draw) >> _S32
    return 1 + int((high * _FACES) >> _S32)


@kernel
def two_dice(game: GameRecord, tick: int, kind: int, a: Row, b: Row, draw: int) -> int:
    """Sum of two dice, 2..12; uses the draws `draw` and `draw + 1`."""
    return die(game, tick, kind, a, b, draw) + die(game, tick, kind, a, b, draw + 1)


@kernel
def priority(game: GameRecord, tick: int, piece: PieceRecord) -> np.uint64:
    """Order of the pieces of one camp where they compete; the lower goes first."""
    return throw(game, tick, Dice.PRIORITY, piece, piece, 0)
