"""Tasks (III-A) as records: what a piece is to do, and how far it has come."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

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

TASK = np.dtype([("kind", "i1"), ("target", "i1"), ("cell", "i2")], align=True)
"""One row of a task set: cell for HOLD, HIDE, DROP (map frame), target for the piece tasks, else -1."""

PLAN = np.dtype(
    [
        ("kind", "i1"),  # TaskKind
        ("target", "i1"),  # piece; NO_PIECE
        ("state", "i1"),  # WALKING, STAYING, ENDED
        ("direction", "i1"),  # last answer of the lower level: 0 stay and perform, else direction + 1
        ("hold_fire", "i1"),  # 1: no fire of opportunity
        ("covered", "i1"),  # 1: prefer covered routes (bots)
        ("cell", "i2"),  # of HOLD, HIDE, DROP; NO_CELL
        ("goal", "i2"),  # the right place as last resolved; NO_CELL
        ("chosen_at", "i2"),
        ("asked_at", "i2"),  # tick at which the lower level was last asked
        ("fire_value", "f4"),  # fire of opportunity from this expected value on, points
        ("stop_value", "f4"),  # a moving piece that may not fire on the move stops for a shot of this value
    ],
    align=True,
)
"""plans[P]: the task under way of every piece, and the style in which it is done."""
