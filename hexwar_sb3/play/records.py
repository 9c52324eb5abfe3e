"""What the drive loop keeps of a game beside the engine's state."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.records import MAX_PIECES
from hexwar_sb3.rules.enums import Action

DECISION_TICKS = 75  # Delta-t of the paper (IV); a setting, not a rule
EARLY_TICKS = 15  # least time between a decision and an early one
EXTERNAL = 255  # seat: somebody outside the loop picks this camp's tasks; else a bot's id

WAITS, JUMPED, STEPS = (
    0,
    1,
    2,
)  # what a turn of the loop came to: somebody must answer, the clock moved, a step

DRIVE = np.dtype(
    [
        ("seat", "u1", (2,)),  # [camp] EXTERNAL or a bot's id
        ("asked", "u1", (2,)),  # [camp] 1: the loop stops at its decisions (always so for EXTERNAL)
        ("period", "i2", (2,)),  # [camp] ticks between its regular decisions
        ("early", "u1", (2,)),  # [camp] 1: also decides after an own loss or an ended task
        ("due", "u1", (2,)),  # [camp] 1: this asked camp is to decide now
        ("fresh", "u1", (2,)),  # [camp] 1: it has picked, and nobody acted on it yet
        ("decided_at", "i2", (2,)),  # [camp] tick of its last decision
        ("ended", "u4", (2,)),  # [camp] bit i: piece i's task had ended before that decision
        ("wake_at", "i2", (2,)),  # [camp] tick at which a bot acts even without news
        ("known", "i8", (2,)),  # [camp] fingerprint of what it knew when it last looked (news.py)
        ("lower", "i2", (2,)),  # [camp] who answers its pieces on their way: play/lower.py
        ("kept", "i1", (MAX_PIECES,)),  # answer that a piece keeps, where `lower` is KEPT
        ("outside", "u4"),  # bit i: somebody outside the loop answers for piece i
        ("waiting", "u4"),  # bit i: piece i waits for that answer now
        ("stepped_at", "i2"),  # tick of the state that the last step made
        ("given", "u1", (MAX_PIECES,)),  # Action given to each piece in the step under way
        ("actions", "i4", (2, len(Action))),  # [camp, Action] orders carried out so far
    ],
    align=True,
)
"""drives[B]: who sits where, when they decide, and what they did."""
