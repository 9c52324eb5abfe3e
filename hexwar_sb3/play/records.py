"""What the drive loop keeps of a game beside the engine's state."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.registry import Bot
from hexwar_sb3.engine.records import MAX_PIECES, NEVER
from hexwar_sb3.records import I1, I2, I4, I8, U1, U8, Table, Vector, dtype_of, within
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import CampIndex, PieceIndex

EARLY_TICKS = 15  # least time between a decision and an early one
LAST_BOT = max(Bot)
EXTERNAL = 255  # seat: somebody outside the loop picks this camp's tasks; else a bot's id
BY_HAND = 254  # seat: somebody outside the loop gives this camp's orders themselves, and the loop none

WAITS, JUMPED, STEPS = (
    0,
    1,
    2,
)  # what a turn of the loop came to: somebody must answer, the clock moved, a step


class DriveRecord:
    """drives[B]: who sits where, when they decide, and what they did."""

    # [camp] EXTERNAL or a bot's id
    seat: Vector[CampIndex, U1[int]] = within(0, LAST_BOT, (2,), also=(EXTERNAL,))
    # [camp] 1: the loop stops at its decisions (always so for EXTERNAL)
    asked: Vector[CampIndex, U1[int]] = within(0, 1, (2,))
    period: Vector[CampIndex, I2[int]] = within(1, NEVER, (2,))  # [camp] ticks between its regular decisions
    # [camp] 1: also decides after an own loss or an ended task
    early: Vector[CampIndex, U1[int]] = within(0, 1, (2,))
    due: Vector[CampIndex, U1[int]] = within(0, 1, (2,))  # [camp] 1: this asked camp is to decide now
    # [camp] 1: it has picked, and nobody acted on it yet
    fresh: Vector[CampIndex, U1[int]] = within(0, 1, (2,))
    decided_at: Vector[CampIndex, I2[int]] = within(0, "tick", (2,))  # [camp] tick of its last decision
    # [camp] bit s: the task of the piece in slot s had ended before that decision
    ended: Vector[CampIndex, U8[np.uint64]] = within(0, "slot_bits", (2,))
    # [camp] tick at which a bot acts even without news
    wake_at: Vector[CampIndex, I2[int]] = within("tick", ("tick", "think_ticks"), (2,), also=(NEVER,))
    # [camp] fingerprint of what it knew when it last looked (fingerprint.py)
    known: Vector[CampIndex, I8[int]] = within(0, 2**62 - 1, (2,))
    # [camp] who answers its pieces on their way: play/lower.py
    lower: Vector[CampIndex, I2[int]] = within(-1, NEVER, (2,))
    # answer that a piece keeps, where `lower` is KEPT
    kept: Vector[PieceIndex, I1[int]] = within(0, 6, (MAX_PIECES,))
    # [piece] 1: somebody outside the loop answers for it
    outside: Vector[PieceIndex, U1[int]] = within(0, 1, (MAX_PIECES,))
    # [piece] 1: it waits for that answer now
    waiting: Vector[PieceIndex, U1[int]] = within(0, 1, (MAX_PIECES,))
    stepped_at: I2[int] = within(0, "tick")  # tick of the state that the last step made
    # Action given to each piece in the step under way
    given: Vector[PieceIndex, U1[int]] = within(0, len(Action) - 1, (MAX_PIECES,))
    # [camp, Action] orders carried out so far
    actions: Table[CampIndex, int, I4[int]] = within(0, "orders", (2, len(Action)))


DRIVE = dtype_of(DriveRecord)
