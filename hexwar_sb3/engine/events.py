"""The event log: one record a fact, written only where somebody asked for a log."""

from __future__ import annotations

from hexwar_sb3.engine.records import GameRecord, Log
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.indices import CellIndex, PieceIndex


@kernel
def note(
    game: GameRecord, log: Log, event: int, a: PieceIndex, b: PieceIndex, cell: CellIndex, extra: int
) -> None:
    """Log a plain event of the step under way."""
    n = game.log_count
    if n >= log.size:
        return
    game.log_count = n + 1
    row = log[n]
    row.tick = game.tick + 1
    row.event = int(event)
    row.a = a
    row.b = b
    row.cell = cell
    row.extra = int(extra)
    row.weapon = -1
    row.level = 0
    row.roll = 0
    row.raw = 0
    row.roll2 = 0
    row.mods = 0
    row.corr = 0
    row.result = 0
    row.cells_apart = 0


@kernel
def note_shot(
    game: GameRecord, log: Log, weapon: int, level: int, roll: int, raw: int, roll2: int, mods: int, corr: int,
    result: int, apart: int,
) -> None:  # fmt: skip
    """Add the dice of a shot to the event that was logged last."""
    n = game.log_count
    if n == 0 or n > log.size:
        return
    row = log[n - 1]
    row.weapon = int(weapon)
    row.level = level
    row.roll = roll
    row.raw = raw
    row.roll2 = roll2
    row.mods = mods
    row.corr = corr
    row.result = result
    row.cells_apart = apart
