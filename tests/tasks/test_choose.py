"""Giving tasks: what goes on and what begins anew."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.choose import AMBUSH_VALUE, FIRE_VALUE, NO_STOP, STOP_VALUE, choose_tasks
from hexwar_sb3.tasks.records import ENDED, STAYING, WALKING, TaskKind

if TYPE_CHECKING:
    from tests.tasks.conftest import Board


def test_the_same_task_goes_on(board: Board) -> None:
    mission = board.task("tank0", TaskKind.HOLD, cell=2449)
    mission.state, mission.goal, mission.fire_value = STAYING, 2449, 9.0
    board.game.tick = 75
    board.task("tank0", TaskKind.HOLD, cell=2449)

    assert (mission.state, mission.goal, mission.fire_value, mission.chosen_at) == (STAYING, 2449, 9.0, 75)


def test_another_cell_or_an_ended_task_begins_anew(board: Board) -> None:
    mission = board.task("tank0", TaskKind.HOLD, cell=2449)
    mission.state = STAYING
    assert board.task("tank0", TaskKind.HOLD, cell=3301).state == WALKING
    mission.state = ENDED
    assert board.task("tank0", TaskKind.HOLD, cell=3301).state == WALKING


def test_the_kind_sets_the_fire_style(board: Board) -> None:
    hide, attack = (
        board.task("tank0", TaskKind.HIDE, cell=2449),
        board.task("tank1", TaskKind.ATTACK, target=7),
    )

    assert (hide.fire_value, hide.stop_value) == (AMBUSH_VALUE, NO_STOP)
    assert (attack.fire_value, attack.stop_value) == (FIRE_VALUE, STOP_VALUE)


def test_an_action_that_names_no_valid_row_stops(board: Board) -> None:
    tasks, mask = board.sets()
    choose_tasks(Camp.RED, np.array([1, 39, -1, 400, 1, 0, 2]), board.game, tasks, mask, board.missions)

    kinds = [TaskKind(mission.kind) for mission in board.missions[:7]]
    assert kinds == [TaskKind.HOLD, *[TaskKind.STOP] * 5, TaskKind.HOLD]
