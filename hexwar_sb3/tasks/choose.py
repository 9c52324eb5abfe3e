"""Giving tasks to pieces: what every chooser (network, bot, person) does with its choice."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import (
    ENDED,
    MISSION,
    WALKING,
    MissionRecord,
    Missions,
    TaskKind,
    TaskRecord,
    TaskSets,
)

FIRE_VALUE = 0.5  # points from which a piece fires at what it sees
AMBUSH_VALUE = 1.5  # the same for a piece whose task is to stay hidden
STOP_VALUE = 2.5  # points for which a piece after an enemy stops, if it cannot fire on the move
NO_STOP = np.inf  # a piece with a place to go to does not stop for a shot


def new_missions(n_games: int, n_pieces: int) -> np.recarray:
    """Missions of a batch [B, P]: everybody stops."""
    missions = np.zeros((n_games, n_pieces), MISSION).view(np.recarray)
    for b in range(n_games):
        clear_missions(missions[b])
    return missions


@kernel
def clear_missions(missions: Missions) -> None:
    """Forget all tasks of one game: a new game begins, everybody stops."""
    for i in piece_range(missions.size):
        missions[i].chosen_at = -1
        missions[i].asked_at = -1
        missions[i].covered = 0
        _begin(missions[i], TaskKind.STOP, NO_PIECE, NO_CELL)


@kernel
def _begin(mission: MissionRecord, kind: int, target: PieceIndex, cell: CellIndex) -> None:
    """Start on a task, in the style that its kind asks for."""
    mission.kind = kind
    mission.target = target
    mission.cell = cell
    mission.state = WALKING
    mission.direction = 0
    mission.goal = NO_CELL
    mission.hold_fire = 0
    mission.fire_value = AMBUSH_VALUE if kind == TaskKind.HIDE or kind == TaskKind.SHADOW else FIRE_VALUE
    hunts = kind == TaskKind.ATTACK or kind == TaskKind.GUIDE or kind == TaskKind.BOMBARD
    mission.stop_value = STOP_VALUE if hunts else NO_STOP


@kernel
def assign(mission: MissionRecord, kind: int, target: PieceIndex, cell: CellIndex, tick: int) -> None:
    """Give a piece a task at a decision point; the one that it already has goes on.

    Fire style (`hold_fire`, `fire_value`, `stop_value`) is reset only by a new task: set it afterwards.
    """
    same = mission.kind == kind and mission.target == target and mission.cell == cell
    if not same or mission.state == ENDED:
        _begin(mission, kind, target, cell)
    mission.chosen_at = tick


@kernel
def choose_task(i: PieceIndex, task: TaskRecord, game: GameRecord, missions: Missions) -> None:
    """Give piece i one row of its task set (a TASK record) at this tick."""
    assign(missions[i], task.kind, task.target, task.cell, game.tick)


@kernel
def choose_tasks(
    camp: CampIndex, actions: Rows, game: GameRecord, tasks: TaskSets, mask: Rows, missions: Missions
) -> None:
    """Give every piece of a camp the row that its action names.

    Args:
        actions: rows of the task sets, [N]; an invalid one stands for row 0, stop; those of empty slots for nothing.
        tasks: task sets of the camp, [N, K] TASK; mask: [N, K], 1 where valid.
    """
    first = first_piece(camp, game)
    for n in range(end_piece(camp, game) - first):
        row = int(actions[n])
        if row < 0 or row >= tasks.shape[1] or mask[n, row] == 0:
            row = 0
        choose_task(PieceIndex(first + n), tasks[n, row], game, missions)
