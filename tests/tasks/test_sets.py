"""Task sets by rule (architecture.md, section 3; III-A)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.tasks.records import MAX_TASKS, TaskKind
from hexwar_sb3.tasks.sets import shorten

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

K = TaskKind
N = 7  # pieces a side


def test_stop_is_always_row_0(middle: Callable[[int], Board]) -> None:
    for seed in range(8):
        tasks, mask = middle(seed).sets()
        assert (tasks[:, 0].kind == K.STOP).all()
        assert (mask[:, 0] == 1).all()
        assert (tasks.kind[:, 1:][mask[:, 1:] == 1] != K.STOP).all()


def test_the_dead_and_those_aboard_can_only_stop(board: Board) -> None:
    board.put("tank0", board.cell(10, 34), blood=0)

    assert board.kinds("tank0") == {K.STOP}
    assert board.kinds("soldier0") == {K.STOP}


def test_at_the_start_nothing_is_known_and_only_spots_are_listed(board: Board) -> None:
    assert board.kinds("tank0") == {K.STOP, K.HOLD, K.HIDE}
    assert board.kinds("chariot0") == {K.STOP, K.HOLD, K.HIDE, K.DROP}
    assert board.kinds("aerocraft0") == {K.STOP, K.HOLD}


def test_hold_is_listed_for_every_control_point_and_spot(board: Board) -> None:
    cells = [cell for kind, _, cell in board.listed("tank0") if kind == K.HOLD]

    assert cells == board.spots[0].tolist()
    assert cells[:2] == [point.cell for point in board.world.scenario.points]


def test_drop_needs_a_passenger(board: Board) -> None:
    board.land("soldier0")

    assert K.DROP not in board.kinds("chariot0")
    assert K.DROP in board.kinds("chariot1")


@pytest.mark.parametrize(
    ("name", "target", "kinds"),
    [
        ("tank0", "blue:tank0", {K.ATTACK, K.SHADOW}),
        ("tank0", "blue:aerocraft0", {K.SHADOW}),
        ("chariot0", "blue:tank0", {K.ATTACK, K.BOMBARD, K.SHADOW}),
        ("chariot0", "blue:aerocraft0", {K.ATTACK, K.SHADOW}),
        ("soldier0", "blue:tank0", {K.ATTACK, K.GUIDE, K.SHADOW}),
        ("soldier0", "blue:aerocraft0", {K.ATTACK, K.SHADOW}),
        ("aerocraft0", "blue:chariot0", {K.ATTACK, K.GUIDE, K.SHADOW}),
        ("aerocraft0", "blue:aerocraft0", {K.SHADOW}),
    ],
)
def test_tasks_on_a_known_enemy(board: Board, name: str, target: str, kinds: set[TaskKind]) -> None:
    """Attack, guide and bombard only what the piece's weapons can hurt."""
    board.land("soldier0")
    j = board.i(target)
    board.memory[0, j].cell, board.memory[0, j].blood = board.cell(40, 40), 1

    assert {kind for kind, to, _ in board.listed(name) if to == j} == kinds


def test_a_piece_without_ammunition_attacks_nobody(board: Board) -> None:
    board.memory[0, N + 0].cell, board.memory[0, N + 0].blood = board.cell(40, 40), 1
    board.pieces[board.i("tank0")].ammo[:] = 0

    assert K.ATTACK not in board.kinds("tank0")


def test_guiding_needs_a_chariot_with_a_missile(board: Board) -> None:
    board.memory[0, N].cell, board.memory[0, N].blood = board.cell(40, 40), 1
    board.land("soldier0")
    board.pieces[board.i("chariot0")].blood = 0

    assert K.GUIDE not in board.kinds("soldier0")  # only its home will do
    assert K.GUIDE in board.kinds("aerocraft0")
    board.pieces[board.i("chariot1")].ammo[:] = 0
    assert K.GUIDE not in board.kinds("aerocraft0")


def test_an_enemy_known_to_be_dead_is_no_target(board: Board) -> None:
    board.memory[0, N].cell, board.memory[0, N].blood = board.cell(40, 40), 0

    assert board.kinds("tank0") == {K.STOP, K.HOLD, K.HIDE}


def test_board_lists_the_empty_chariots(board: Board) -> None:
    board.land("soldier0")

    carriers = [to for kind, to, _ in board.listed("soldier0") if kind == K.BOARD]

    assert carriers == [board.i("chariot0")]  # chariot1 still carries its own soldier


def test_recover_is_listed_only_while_it_is_legal(board: Board) -> None:
    tank = board.pieces[board.i("tank0")]
    assert K.RECOVER not in board.kinds("tank0")
    tank.suppressed, tank.keep_ends = 1, 76
    assert K.RECOVER in board.kinds("tank0")
    tank.keep_ends = 75
    assert K.RECOVER not in board.kinds("tank0")


def test_over_the_limit_shadow_rows_go_first_then_the_farthest() -> None:
    rows = [
        (K.STOP, NO_PIECE, NO_CELL, 0),
        (K.HOLD, NO_PIECE, 5, 900),
        (K.HOLD, NO_PIECE, 6, 20),
        (K.ATTACK, 7, NO_CELL, 600),
        (K.SHADOW, 7, NO_CELL, 40),
        (K.SHADOW, 8, NO_CELL, 60),
    ]
    draft = np.array(rows, np.int16)

    assert shorten(draft, len(rows), 5) == 5
    assert draft[:5, 1].tolist() == [NO_PIECE, NO_PIECE, NO_PIECE, 7, 7]
    assert shorten(draft, 5, 3) == 3
    assert draft[:3].tolist() == [list(rows[0]), list(rows[2]), list(rows[3])]


def test_rows_behind_the_last_task_are_blank(board: Board) -> None:
    tasks, mask = board.sets()
    blank = tasks[mask == 0]

    assert (blank.kind == K.STOP).all()
    assert (blank.target == NO_PIECE).all()
    assert (blank.cell == NO_CELL).all()
    assert (np.diff(mask, axis=1) <= 0).all()


def test_two_tanks_that_change_places_change_task_sets(middle: Callable[[int], Board]) -> None:
    """A set depends on what a piece is and where, not on its slot."""
    board = middle(3)
    one, two = board.i("tank0"), board.i("tank1")
    before, mask = board.sets()
    board.pieces[[one, two]] = board.pieces[[two, one]]
    after, mask_after = board.sets()

    assert after[one].tobytes() == before[two].tobytes()
    assert mask_after[two].tobytes() == mask[one].tobytes()


def test_no_task_set_is_longer_than_its_room(board: Board) -> None:
    for j in range(N, 2 * N):
        board.memory[0, j].cell, board.memory[0, j].blood = board.cell(40, 40), 1

    kinds = [kind for kind, _, _ in board.listed("chariot0")]
    assert len(kinds) == MAX_TASKS
    assert [kinds.count(kind) for kind in (K.HOLD, K.HIDE, K.DROP, K.ATTACK, K.BOMBARD)] == [8, 8, 8, 7, 6]
    tasks, mask = board.sets(k=20)
    assert mask[board.i("chariot0")].sum() == 20
    assert K.SHADOW not in tasks[board.i("chariot0")].kind


def test_a_busy_or_moving_piece_has_the_same_tasks(board: Board) -> None:
    """Whether an action is possible now is a feature, not a reason to hide the task."""
    standing = board.listed("tank0")
    board.pieces[board.i("tank0")].stop_ends = 40
    assert board.pieces[board.i("tank0")].arrives_at == NEVER
    assert board.listed("tank0") == standing
