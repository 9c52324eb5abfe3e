"""Tasks (III-A) as records: what a piece is to do, and how far it has come."""

from __future__ import annotations

from enum import IntEnum
from typing import TypeAlias

import numpy as np

from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.records import F4, I1, I2, I4, Table, Vector, dtype_of, within
from hexwar_sb3.rules.indices import CellIndex, PieceIndex

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


class TaskRecord:
    """One row of a task set: cell for HOLD, HIDE, DROP (map frame), target for the piece tasks, else -1."""

    kind: I1[int]
    target: I1[PieceIndex]
    cell: I4[CellIndex]


TASK = dtype_of(TaskRecord)
Tasks: TypeAlias = Vector[int, TaskRecord]  # a task set
TaskSets: TypeAlias = Table[int, int, TaskRecord]  # of a camp: [slot, row]


class MissionRecord:
    """The task under way of a piece, and the style in which it is done."""

    kind: I1[int] = within(0, TaskKind.RECOVER)  # TaskKind
    target: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # piece; NO_PIECE
    state: I1[int] = within(WALKING, ENDED)  # WALKING, STAYING, ENDED
    # last answer of the lower level: 0 stay and perform, else direction + 1
    direction: I1[int] = within(0, 6)
    hold_fire: I1[int] = within(0, 1)  # 1: no fire of opportunity
    covered: I1[int] = within(0, 1)  # 1: prefer covered routes (bots)
    cell: I4[CellIndex] = within(NO_CELL, "last_cell")  # of HOLD, HIDE, DROP; NO_CELL
    goal: I4[CellIndex] = within(NO_CELL, "last_cell")  # the right place as last resolved; NO_CELL
    chosen_at: I2[int] = within(-1, "tick")
    asked_at: I2[int] = within(-1, "tick")  # tick at which the lower level was last asked
    # fire of opportunity from this expected value on, points
    fire_value: F4[float] = within(0, MOST_VALUE)
    # a moving piece that may not fire on the move stops for a shot of this value; infinite: for none
    stop_value: F4[float] = within(0, MOST_VALUE, also=(np.inf,))


MISSION = dtype_of(MissionRecord)
Missions: TypeAlias = Vector[PieceIndex, MissionRecord]  # of one game
