"""Giving tasks to pieces: what every chooser (network, bot, person) does with its choice."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import first_piece
from hexwar_sb3.tasks.records import ENDED, PLAN, WALKING, PlanRecord, Plans, TaskKind, TaskRecord, TaskSets

FIRE_VALUE = 0.5  # points from which a piece fires at what it sees
AMBUSH_VALUE = 1.5  # the same for a piece whose task is to stay hidden
STOP_VALUE = 2.5  # points for which a piece after an enemy stops, if it cannot fire on the move
NO_STOP = np.inf  # a piece with a place to go to does not stop for a shot


def new_plans(n_games: int, n_pieces: int) -> np.recarray:
    """Plans of a batch [B, P]: everybody stops."""
    plans = np.zeros((n_games, n_pieces), PLAN).view(np.recarray)
    for b in range(n_games):
        clear_plans(plans[b])
    return plans


@kernel
def clear_plans(plans: Plans) -> None:
    """Forget all tasks of one game: a new game begins, everybody stops."""
    for i in piece_range(plans.size):
        plans[i].chosen_at = -1
        plans[i].asked_at = -1
        plans[i].covered = 0
        _begin(plans[i], TaskKind.STOP, NO_PIECE, NO_CELL)


@kernel
def _begin(plan: PlanRecord, kind: int, target: PieceIndex, cell: CellIndex) -> None:
    """Start on a task, in the style that its kind asks for."""
    plan.kind = kind
    plan.target = target
    plan.cell = cell
    plan.state = WALKING
    plan.direction = 0
    plan.goal = NO_CELL
    plan.hold_fire = 0
    plan.fire_value = AMBUSH_VALUE if kind == TaskKind.HIDE or kind == TaskKind.SHADOW else FIRE_VALUE
    hunts = kind == TaskKind.ATTACK or kind == TaskKind.GUIDE or kind == TaskKind.BOMBARD
    plan.stop_value = STOP_VALUE if hunts else NO_STOP


@kernel
def assign(plan: PlanRecord, kind: int, target: PieceIndex, cell: CellIndex, tick: int) -> None:
    """Give a piece a task at a decision point; the one that it already has goes on.

    Fire style (`hold_fire`, `fire_value`, `stop_value`) is reset only by a new task: set it afterwards.
    """
    same = plan.kind == kind and plan.target == target and plan.cell == cell
    if not same or plan.state == ENDED:
        _begin(plan, kind, target, cell)
    plan.chosen_at = tick


@kernel
def choose_task(i: PieceIndex, task: TaskRecord, game: GameRecord, plans: Plans) -> None:
    """Give piece i one row of its task set (a TASK record) at this tick."""
    assign(plans[i], task.kind, task.target, task.cell, game.tick)


@kernel
def choose_tasks(
    camp: CampIndex, actions: Rows, game: GameRecord, tasks: TaskSets, mask: Rows, plans: Plans
) -> None:
    """Give every piece of a camp the row that its action names.

    Args:
        actions: rows of the task sets, [N]; an invalid one stands for row 0, stop.
        tasks: task sets of the camp, [N, K] TASK; mask: [N, K], 1 where valid.
    """
    first = first_piece(camp, game)
    for n in range(actions.size):
        row = int(actions[n])
        if row < 0 or row >= tasks.shape[1] or mask[n, row] == 0:
            row = 0
        choose_task(PieceIndex(first + n), tasks[n, row], game, plans)
