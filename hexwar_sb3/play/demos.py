"""What a bot does, said in the words of the task sets, for learners that may watch."""

from __future__ import annotations

from hexwar_sb3.engine.pieces import next_cell_of
from hexwar_sb3.engine.records import NEVER, NO_CELL, GameRecord, Paths, Pieces
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart, direction_between, frame_direction
from hexwar_sb3.rules.indices import CampIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import MissionRecord, Missions, Tasks, TaskSets
from hexwar_sb3.tasks.route import STAY


@kernel
def name_missions(
    camp: CampIndex,
    game: GameRecord,
    missions: Missions,
    tasks: TaskSets,
    mask: Rows,
    cells: Cells,
    actions: Rows,
) -> None:
    """Write the task index that comes nearest to each mission of a camp.

    Args:
        missions: of both camps, [P].
        tasks, mask: the camp's task sets, [N, K].
        actions: out, [N].
    """
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        actions[SlotIndex(i - first)] = nearest_task(
            missions[i], tasks[SlotIndex(i - first)], mask[SlotIndex(i - first)], cells
        )


@kernel
def nearest_task(mission: MissionRecord, tasks: Tasks, mask: Rows, cells: Cells) -> int:
    """Valid row of the mission's kind and target with the nearest cell; 0, stop, if there is none."""
    best, best_apart = 0, NEVER
    for k in range(tasks.size):
        task = tasks[k]
        if mask[k] == 0 or task.kind != mission.kind or task.target != mission.target:
            continue
        apart = 0
        if task.cell != NO_CELL and mission.cell != NO_CELL:
            apart = cells_apart(cells, task.cell, mission.cell)
        if apart < best_apart:
            best, best_apart = k, apart
    return best


@kernel
def name_moves(
    camp: CampIndex, game: GameRecord, pieces: Pieces, paths: Paths, cells: Cells, answers: Rows
) -> None:
    """Write the answer of the lower level that leads each piece of a camp where its path leads next.

    Args:
        pieces: of both camps, [P].
        paths: theirs, [P, cells].
        answers: out, [N]; staying without a path.
    """
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        there = next_cell_of(pieces[i], paths[i], cells)
        if there == NO_CELL:
            answers[SlotIndex(i - first)] = STAY
        else:
            answers[SlotIndex(i - first)] = 1 + frame_direction(
                direction_between(cells, pieces[i].cell, there), camp
            )
