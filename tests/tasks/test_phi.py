"""phi, eq. (2): one order for every pair of task and answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.maps.geometry import E
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.tasks.phi import may_occupy, may_turn_back, phi
from hexwar_sb3.tasks.records import TaskKind

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

K = TaskKind


def order(field: Board, name: str, answer: int) -> Action:
    i = field.i(name)
    field.orders.kind = Action.NULL
    given = phi(
        i,
        answer,
        field.game,
        field.pieces,
        field.memory,
        field.orders,
        field.missions,
        field.rules,
        field.cells,
    )
    assert given == (field.orders[i].kind != Action.NULL)
    return Action(field.orders[i].kind)


def test_an_answer_above_0_is_one_hop_in_that_direction(field: Board) -> None:
    field.task("tank0", K.HOLD, cell=field.cell(20, 10))

    assert order(field, "tank0", E + 1) == Action.MOVE
    assert (field.orders[0].path_len, field.orders[0].path[0]) == (1, E)


def test_a_hop_that_is_not_legal_gives_no_order(field: Board) -> None:
    field.task("tank0", K.HOLD, cell=field.cell(20, 10))
    field.pieces[0].hide_ends = 30

    assert order(field, "tank0", E + 1) == Action.NULL


def test_hide_and_drop_act_only_at_their_cell(field: Board) -> None:
    here = int(field.pieces[0].cell)
    field.task("tank0", K.HIDE, cell=field.cell(20, 10))
    assert order(field, "tank0", 0) == Action.NULL
    field.task("tank0", K.HIDE, cell=here)
    assert order(field, "tank0", 0) == Action.HIDE

    field.task("chariot0", K.DROP, cell=field.cell(20, 10))
    assert order(field, "chariot0", 0) == Action.NULL
    field.task("chariot0", K.DROP, cell=int(field.pieces[2].cell))
    assert order(field, "chariot0", 0) == Action.GET_OFF
    assert field.orders[2].target == field.i("soldier0")


def test_hold_has_no_action_of_its_own(field: Board) -> None:
    field.task("tank0", K.HOLD, cell=int(field.pieces[0].cell))
    assert order(field, "tank0", 0) == Action.NULL


def test_board_needs_the_chariot_in_the_same_cell(field: Board) -> None:
    field.land("soldier0")
    field.task("soldier0", K.BOARD, target=field.i("chariot0"))
    assert order(field, "soldier0", 0) == Action.GET_ON
    field.put("chariot0", field.cell(20, 2))
    assert order(field, "soldier0", 0) == Action.NULL


def test_recover_is_decompress(field: Board) -> None:
    field.put("tank0", field.cell(20, 2), suppressed=1, keep_ends=100)
    field.task("tank0", K.RECOVER)
    assert order(field, "tank0", 0) == Action.DECOMPRESS


def test_bombard_fires_where_the_enemy_was_last_seen_unless_an_own_piece_stands_there(field: Board) -> None:
    field.put("chariot0", field.cell(10, 2))
    field.put("blue:tank0", field.cell(20, 2))
    field.look()
    field.task("chariot0", K.BOMBARD, target=field.i("blue:tank0"))
    assert order(field, "chariot0", 0) == Action.INDIRECT_SHOOT
    assert field.orders[2].cell == field.cell(20, 2)
    field.put("tank0", field.cell(20, 2))
    assert order(field, "chariot0", 0) == Action.NULL


@pytest.mark.parametrize(("done", "turns_back"), [(0, True), (9, True), (10, False), (19, False)])
def test_stop_is_ordered_only_where_it_turns_the_piece_back(
    field: Board, done: int, turns_back: bool
) -> None:
    """In the second half of a hop a stop would only make the transition a forced one (section 4)."""
    tank = field.put("tank0", field.cell(20, 2), path_len=1, hop_need=20, arrives_at=20 - done)
    field.task("tank0", K.STOP)

    assert may_turn_back(tank, 0) == turns_back
    assert order(field, "tank0", 0) == (Action.STOP if turns_back else Action.NULL)


def test_a_point_is_not_occupied_while_an_enemy_is_seen_beside_it(field: Board) -> None:
    field.put("tank0", field.cell(20, 10))
    field.look()
    args = (field.game, field.pieces, field.memory, field.cells)
    assert may_occupy(PieceIndex(0), *args)
    field.put("blue:tank0", field.cell(21, 10))
    field.look()
    assert not may_occupy(PieceIndex(0), *args)
    field.memory[0, 7].blood = 0
    assert may_occupy(PieceIndex(0), *args)
    assert field.pieces[0].carrier == NO_PIECE
