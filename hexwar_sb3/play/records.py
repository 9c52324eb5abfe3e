"""What the drive loop keeps of a game beside the engine's state."""

from __future__ import annotations

from hexwar_sb3.bots.drawn_records import SQUADS, STAGES
from hexwar_sb3.bots.records import CHOICES
from hexwar_sb3.bots.registry import Bot
from hexwar_sb3.engine.fields import ANY_U4, Field, dtype_of
from hexwar_sb3.engine.records import MAX_PIECES, MAX_POINTS, MAX_SIDE, NEVER, NO_CELL
from hexwar_sb3.rules.enums import Action

EARLY_TICKS = 15  # least time between a decision and an early one
LAST_BOT = max(Bot)
EXTERNAL = 255  # seat: somebody outside the loop picks this camp's tasks; else a bot's id

WAITS, JUMPED, STEPS = (
    0,
    1,
    2,
)  # what a turn of the loop came to: somebody must answer, the clock moved, a step

DRIVE_FIELDS = (
    Field("seat", "u1", 0, LAST_BOT, (2,), (EXTERNAL,)),  # [camp] EXTERNAL or a bot's id
    # [camp] 1: the loop stops at its decisions (always so for EXTERNAL)
    Field("asked", "u1", 0, 1, (2,)),
    Field("period", "i2", 1, NEVER, (2,)),  # [camp] ticks between its regular decisions
    # [camp] 1: also decides after an own loss or an ended task
    Field("early", "u1", 0, 1, (2,)),
    Field("due", "u1", 0, 1, (2,)),  # [camp] 1: this asked camp is to decide now
    Field("fresh", "u1", 0, 1, (2,)),  # [camp] 1: it has picked, and nobody acted on it yet
    Field("decided_at", "i2", 0, "tick", (2,)),  # [camp] tick of its last decision
    # [camp] bit i: piece i's task had ended before that decision
    Field("ended", "u4", 0, "piece_bits", (2,)),
    # [camp] tick at which a bot acts even without news
    Field("wake_at", "i2", "tick", ("tick", "think_ticks"), (2,), (NEVER,)),
    # [camp] fingerprint of what it knew when it last looked (news.py)
    Field("known", "i8", 0, 2**62 - 1, (2,)),
    Field("lower", "i2", -1, NEVER, (2,)),  # [camp] who answers its pieces on their way: play/lower.py
    Field("kept", "i1", 0, 6, (MAX_PIECES,)),  # answer that a piece keeps, where `lower` is KEPT
    Field("outside", "u4", 0, "piece_bits"),  # bit i: somebody outside the loop answers for piece i
    Field("waiting", "u4", 0, "piece_bits"),  # bit i: piece i waits for that answer now
    Field("stepped_at", "i2", 0, "tick"),  # tick of the state that the last step made
    # Action given to each piece in the step under way
    Field("given", "u1", 0, len(Action) - 1, (MAX_PIECES,)),
    # [camp, Action] orders carried out so far
    Field("actions", "i4", 0, "orders", (2, len(Action))),
)
DRIVE = dtype_of(DRIVE_FIELDS)
"""drives[B]: who sits where, when they decide, and what they did."""

# Beside `bots.records.BRAIN` it would change the hash of the bots, which every result carries.
BRAIN_FIELDS = (
    Field("thoughts", "u4", 0, ("tick", 1)),
    Field("draws", "u4", 0, ANY_U4),
    Field("thought_at", "i2", 0, "tick"),
    Field("wake_at", "i2", 0, ("tick", "think_ticks")),
    Field("loss_at", "i2", -1, "tick"),
    Field("contact_at", "i2", -1, "tick"),
    Field("point", "i1", 0, "last_point", (MAX_SIDE,)),
    Field("post", "i2", NO_CELL, "last_cell", (MAX_SIDE,)),
    Field("dropped_for", "i1", 0, ("last_point", 1), (MAX_SIDE,)),
    Field("taker", "i1", -1, MAX_SIDE - 1, (MAX_POINTS,)),
    Field("keeper", "i1", -1, MAX_SIDE - 1, (MAX_POINTS,)),
    Field("rush", "u1", 0, 1),
    Field("n_foes", "u1", 0, MAX_SIDE),
    Field("foes", "i1", 0, "last_piece", (MAX_SIDE,)),
    Field("trust", "f4", 0, 1, (MAX_PIECES,)),
    Field("choices", "i2", NO_CELL, "last_cell", (CHOICES,)),
    Field("allotted", "i2", 0, "losses", (MAX_PIECES,)),
    Field("stage", "i1", 0, STAGES - 1, (SQUADS,)),
    Field("since", "i2", 0, "tick", (SQUADS,)),
)
"""What may stand in a scripted player's brain; what was drawn for it must be what its seed draws."""
