"""phi, eq. (2): one order for every pair of task and answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from hexwar_sb3.engine.records import NO_PIECE, ROUND_BURSTING, ROUND_FLYING
from hexwar_sb3.maps.geometry import E
from hexwar_sb3.rules.enums import Action, Camp, Weapon
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.tasks.phi import (
    give_guided,
    give_shot,
    has_flying_round,
    is_own_in,
    may_occupy,
    may_turn_back,
    phi,
)
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


def test_a_shadow_hides_at_its_cell_or_wherever_it_has_none(field: Board) -> None:
    here = int(field.pieces[0].cell)
    for cell, action in ((here, Action.HIDE), (-1, Action.HIDE), (here + 1, Action.NULL)):
        field.task("tank0", K.SHADOW, cell=cell)
        assert order(field, "tank0", 0) == action


def test_an_attack_and_a_guide_have_no_action_of_their_own(field: Board) -> None:
    """Their shots come from `execute`, which sees all shooters."""
    field.land("soldier0")
    field.put("blue:tank0", field.cell(10, 2))
    field.look()
    for name, kind in (("tank0", K.ATTACK), ("soldier0", K.GUIDE)):
        field.task(name, kind, target=field.i("blue:tank0"))
        assert order(field, name, 0) == Action.NULL


def test_a_piece_that_waits_or_is_told_to_stop_already(field: Board) -> None:
    """Who waits for room may be stopped at any time; who has its order to stop need not be told twice."""
    tank = field.put("tank0", field.cell(20, 2), path_len=1, hop_need=20, arrives_at=1)
    assert not may_turn_back(tank, 0)
    tank.waiting = 1
    assert may_turn_back(tank, 0)
    tank.stop_pending = 1
    assert not may_turn_back(tank, 0)
    field.put("tank0", field.cell(20, 2), path_len=0, stop_pending=0)
    assert not may_turn_back(tank, 0)


def test_a_round_binds_its_chariot_until_it_has_landed(field: Board) -> None:
    """Section 9 of the rule book: a move before that calls it off."""
    field.rounds[1].owner = field.i("chariot1")
    for status, flies in ((ROUND_FLYING, True), (ROUND_BURSTING, False)):
        field.rounds[1].status = status
        assert has_flying_round(field.i("chariot1"), field.rounds) == flies
        assert not has_flying_round(field.i("chariot0"), field.rounds)


def test_own_ground_pieces_are_spared_and_enemies_and_aerocraft_are_not_counted(field: Board) -> None:
    cell = field.cell(20, 2)
    for name in ("aerocraft0", "blue:tank0"):
        field.put(name, cell)
    assert not is_own_in(Camp.RED, cell, field.game, field.pieces)
    assert is_own_in(Camp.BLUE, cell, field.game, field.pieces)
    field.put("tank0", cell)
    assert is_own_in(Camp.RED, cell, field.game, field.pieces)


def test_a_shot_is_ordered_with_its_target_and_weapon_or_not_at_all(field: Board) -> None:
    field.put("tank0", field.cell(10, 2))
    j = PieceIndex(field.put("blue:tank0", field.cell(20, 2)).slot + 7)
    field.look()
    args = (field.game, field.pieces, field.orders, field.rules, field.cells)
    assert give_shot(PieceIndex(0), j, Weapon.GUN, *args)
    assert (field.orders[0].kind, field.orders[0].target, field.orders[0].weapon) == (
        Action.SHOOT,
        j,
        Weapon.GUN,
    )
    assert not give_shot(PieceIndex(0), j, Weapon.LIGHT, *args)
    assert field.orders[0].kind == Action.NULL


def test_a_guided_shot_is_ordered_with_its_chariot_or_not_at_all(field: Board) -> None:
    field.land("soldier0")
    i, c = field.i("soldier0"), field.i("chariot0")
    field.put("soldier0", field.cell(10, 2))
    field.put("chariot0", field.cell(8, 2))
    field.put("blue:tank0", field.cell(20, 2))
    field.look()
    args = (field.game, field.pieces, field.orders, field.rules, field.cells)
    assert give_guided(i, field.i("blue:tank0"), c, *args)
    row = field.orders[i]
    assert (row.kind, row.target, row.partner) == (Action.GUIDE_SHOOT, field.i("blue:tank0"), c)
    assert not give_guided(i, field.i("blue:tank0"), field.i("chariot1"), *args)
    assert row.kind == Action.NULL


def test_orders_without_a_target_or_a_cell_say_so(field: Board) -> None:
    """What an earlier order named is not left in its place."""
    field.orders[0].target, field.orders[0].cell = 9, 99
    field.task("tank0", K.HIDE, cell=int(field.pieces[0].cell))
    assert order(field, "tank0", 0) == Action.HIDE
    assert (field.orders[0].target, field.orders[0].cell) == (NO_PIECE, -1)


def test_nobody_boards_in_close_combat(field: Board) -> None:
    """Section 10 of the rule book: pieces in it may only leave."""
    field.land("soldier0")
    field.task("soldier0", K.BOARD, target=field.i("chariot0"))
    field.game.fight_cell[0] = field.pieces[field.i("soldier0")].cell
    field.game.n_fights = 1
    assert order(field, "soldier0", 0) == Action.NULL


def test_only_the_task_to_stop_turns_a_piece_back(field: Board) -> None:
    field.put("tank0", field.cell(20, 2), path_len=1, hop_need=20, arrives_at=18)
    for kind in (K.HOLD, K.ATTACK, K.GUIDE):
        field.task("tank0", kind, target=field.i("blue:tank0"), cell=field.cell(20, 2))
        assert order(field, "tank0", 0) == Action.NULL
