"""Tasks (III-A) as records: what a piece is to do, and how far it has come."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from hexwar_sb3.engine.fields import Field, dtype_of
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE

MAX_TASKS = 40  # K_max: rows of a task set


class TaskKind(IntEnum):
    """Kinds of tasks (architecture.md, section 3; III-A)."""

    STOP = 0
    HOLD = 1
    HIDE = 2
    DROP = 3
    ATTACK = 4
    GUIDE = 5
    BOMBARD = 6
    SHADOW = 7
    BOARD = 8
    RECOVER = 9


WALKING, STAYING, ENDED = 0, 1, 2
MOST_VALUE = 1e6  # of a shot, points; no rule set comes near

TASK = np.dtype([("kind", "i1"), ("target", "i1"), ("cell", "i2")], align=True)
"""One row of a task set: cell for HOLD, HIDE, DROP (map frame), target for the piece tasks, else -1."""

PLAN_FIELDS = (
    Field("kind", "i1", 0, TaskKind.RECOVER),  # TaskKind
    Field("target", "i1", NO_PIECE, "last_piece"),  # piece; NO_PIECE
    Field("state", "i1", WALKING, ENDED),  # WALKING, STAYING, ENDED
    # last answer of the lower level: 0 stay and perform, else direction + 1
    Field("direction", "i1", 0, 6),
    Field("hold_fire", "i1", 0, 1),  # 1: no fire of opportunity
    Field("covered", "i1", 0, 1),  # 1: prefer covered routes (bots)
    Field("cell", "i2", NO_CELL, "last_cell"),  # of HOLD, HIDE, DROP; NO_CELL
    Field("goal", "i2", NO_CELL, "last_cell"),  # the right place as last resolved; NO_CELL
    Field("chosen_at", "i2", -1, "tick"),
    Field("asked_at", "i2", -1, "tick"),  # tick at which the lower level was last asked
    # fire of opportunity from this expected value on, points
    Field("fire_value", "f4", 0, MOST_VALUE),
    # a moving piece that may not fire on the move stops for a shot of this value; infinite: for none
    Field("stop_value", "f4", 0, MOST_VALUE, (), (np.inf,)),
)
PLAN = dtype_of(PLAN_FIELDS)
"""plans[P]: the task under way of every piece, and the style in which it is done."""
