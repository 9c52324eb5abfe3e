"""From tasks to orders over time (architecture.md, section 3): who asks when, who fires, who waits."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.records import MAX_PIECES, NEVER, NO_PIECE
from hexwar_sb3.maps.geometry import E
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.tasks.execute import fires_itself
from hexwar_sb3.tasks.records import ENDED, STAYING, WALKING, TaskKind
from hexwar_sb3.tasks.shots import best_shot

if TYPE_CHECKING:
    from tests.tasks.conftest import Board, Choose

K = TaskKind


def meet(field: Board, name: str, apart: int) -> int:
    """A blue chariot some cells east of a red piece in the open; its index."""
    field.put(name, field.cell(10, 2))
    field.put("blue:chariot0", field.cell(10 + apart, 2))
    field.look()
    return field.i("blue:chariot0")


def test_only_legal_orders_are_given(board: Board, sticky: Callable[[int], Choose]) -> None:
    """Over whole games of random tasks: a refused order would cost its piece the step."""
    for seed in range(3):
        game = type(board)(board.world, seed)
        game.play(1800, sticky(seed))
        assert game.codes
        assert set(game.codes) == {Code.OK}


def test_a_chain_of_hops_costs_no_delay(field: Board) -> None:
    """Each hop is ordered in the very tick of the arrival, so five cells take five hop times."""
    field.put("tank0", field.cell(10, 2))
    field.task("tank0", K.HOLD, cell=field.cell(15, 2))
    field.run(100)

    assert field.pieces[0].cell == field.cell(15, 2)
    assert field.pieces[0].arrived_at == 100


def test_the_lower_level_is_asked_on_arrival_and_at_decisions_only(field: Board) -> None:
    field.put("tank0", field.cell(10, 2))
    mission = field.task("tank0", K.HOLD, cell=field.cell(15, 2))
    field.run(19)
    assert mission.asked_at == 0
    field.run(20)
    field.execute()
    assert (mission.asked_at, mission.state, mission.direction) == (20, WALKING, E + 1)
    field.run(300)
    assert (mission.asked_at, mission.state) == (100, STAYING)
    field.task("tank0", K.HOLD, cell=field.cell(15, 2))
    field.execute()
    assert mission.asked_at == 300


def test_another_task_in_the_middle_of_a_hop_waits_for_its_end(field: Board) -> None:
    field.put("tank0", field.cell(10, 2))
    field.task("tank0", K.HOLD, cell=field.cell(15, 2))
    field.run(5)
    mission = field.task("tank0", K.HOLD, cell=field.cell(5, 2))
    assert field.ordered("tank0") == Action.NULL
    field.run(121)

    assert field.pieces[0].cell == field.cell(6, 2)
    assert mission.state == WALKING


def test_stop_turns_back_and_ends(field: Board) -> None:
    field.put("tank0", field.cell(10, 2))
    field.task("tank0", K.HOLD, cell=field.cell(15, 2))
    field.run(5)
    mission = field.task("tank0", K.STOP)
    assert field.ordered("tank0") == Action.STOP
    field.run(10)
    assert field.pieces[0].cell == field.cell(10, 2)
    assert mission.state == ENDED


def test_a_point_is_occupied_on_the_way_and_the_way_goes_on(field: Board) -> None:
    field.put("tank0", field.cell(19, 10))
    field.task("tank0", K.HOLD, cell=field.cell(22, 10))
    field.run(200)

    assert field.game.point_owner[0] == 0
    assert field.pieces[0].cell == field.cell(22, 10)
    assert field.pieces[0].arrived_at == 61  # one tick for the order to occupy


def test_a_contested_point_is_not_asked_for_every_tick(field: Board) -> None:
    field.put("tank0", field.cell(20, 10), cool_ends=70)
    field.put("blue:soldier0", field.cell(21, 10), carrier=NO_PIECE)
    field.look()
    field.task("tank0", K.HOLD, cell=field.cell(20, 10))
    assert field.ordered("tank0") == Action.NULL


def test_hide_and_drop_are_done_as_soon_as_they_are_legal(field: Board) -> None:
    field.put("tank0", field.cell(10, 2))
    field.put("chariot0", field.cell(10, 6))
    field.task("tank0", K.HIDE, cell=field.cell(11, 2))
    drop = field.task("chariot0", K.DROP, cell=field.cell(11, 6))
    field.run(20 + 75 + 75 + 1)

    assert field.pieces[0].hidden
    assert field.pieces[field.i("soldier0")].carrier == NO_PIECE
    field.execute()
    assert drop.state == ENDED


def test_a_settled_piece_fires_at_what_it_sees(field: Board) -> None:
    meet(field, "tank0", 5)
    mission = field.task("tank0", K.HOLD, cell=field.cell(10, 2))
    assert field.ordered("tank0") == Action.SHOOT
    mission.fire_value = 1000.0
    assert field.ordered("tank0") == Action.NULL
    mission.fire_value, mission.hold_fire = 0.5, 1
    assert field.ordered("tank0") == Action.NULL


def test_an_attack_fires_at_its_own_target_even_under_held_fire(field: Board) -> None:
    j = meet(field, "tank0", 5)
    field.put("blue:tank0", field.cell(12, 2), blood=1)
    field.look()
    mission = field.task("tank0", K.ATTACK, target=j)
    mission.hold_fire = 1

    assert field.ordered("tank0") == Action.SHOOT
    assert field.orders[0].target == j


def test_two_shooters_of_one_step_do_not_both_aim_at_the_last_survivor(field: Board) -> None:
    """Losses already expected count against the next shot (bots.md, section 1)."""
    meet(field, "tank0", 5)
    field.pieces[field.i("blue:chariot0")].blood = 1
    field.put("tank1", field.cell(10, 2))
    field.put("blue:tank0", field.cell(13, 4), blood=1)
    field.look()
    for name in ("tank0", "tank1"):
        field.task(name, K.HOLD, cell=field.cell(10, 2))
    field.execute()

    assert [field.orders[i].kind for i in (0, 1)] == [Action.SHOOT, Action.SHOOT]
    assert field.orders[0].target != field.orders[1].target


def test_a_tank_fires_its_gun_without_giving_up_its_way(field: Board) -> None:
    field.pieces[meet(field, "tank0", 12)].ammo[:] = 0
    field.task("tank0", K.HOLD, cell=field.cell(4, 2))
    field.run(60)

    assert field.pieces[0].ammo[0] < 30
    assert field.pieces[0].cell <= field.cell(8, 2)


def test_a_chariot_does_not_move_on_for_a_shot_worth_a_stop(field: Board) -> None:
    meet(field, "chariot0", 8)
    mission = field.task("chariot0", K.HOLD, cell=field.cell(5, 2))
    field.pieces[2].stop_ends = 40
    assert field.ordered("chariot0") == Action.MOVE
    mission.stop_value = 2.5
    assert field.ordered("chariot0") == Action.NULL
    field.pieces[2].stop_ends = NEVER
    assert field.ordered("chariot0") == Action.SHOOT


def test_a_chariot_under_way_stops_for_a_new_contact(field: Board) -> None:
    meet(field, "chariot0", 8)
    mission = field.task("chariot0", K.HOLD, cell=field.cell(5, 2))
    field.put("chariot0", field.cell(10, 2), path_len=1, hop_need=20, arrives_at=18)
    assert field.ordered("chariot0") == Action.NULL
    mission.stop_value = 2.5
    assert field.ordered("chariot0") == Action.STOP
    field.game.contact_tick[0] = -1
    assert field.ordered("chariot0") == Action.NULL


def test_guide_fires_the_chariots_missile(field: Board) -> None:
    j = meet(field, "soldier0", 8)
    field.land("soldier0")
    field.put("chariot0", field.cell(6, 2))
    field.look()
    mission = field.task("soldier0", K.GUIDE, target=j)
    field.missions[2].hold_fire = 1  # else the chariot fires by itself: its shot is as good

    field.execute()
    row = field.orders[field.i("soldier0")]
    assert (row.kind, row.target, row.partner) == (Action.GUIDE_SHOOT, j, field.i("chariot0"))
    assert mission.state == STAYING
    field.orders.kind = Action.NULL
    field.missions[2].hold_fire = 0
    field.execute()
    assert field.orders[field.i("soldier0")].kind != Action.GUIDE_SHOOT
    assert field.orders[2].kind == Action.SHOOT


@pytest.mark.parametrize(("share", "itself"), [(0.79, False), (0.81, True), (1.0, True)])
def test_a_chariot_whose_shot_is_worth_four_fifths_of_the_guided_one_fires_itself(
    field: Board, share: float, itself: bool
) -> None:
    meet(field, "chariot0", 8)
    field.task("chariot0", K.HOLD, cell=field.cell(10, 2))
    chariot, allotted = field.i("chariot0"), np.zeros(MAX_PIECES, np.int64)
    seen = (allotted, field.game, field.pieces, field.memory)
    value, _, _ = best_shot(chariot, NO_PIECE, False, *seen, field.rules, field.cells)

    assert value > 0.0
    assert fires_itself(chariot, value / share, *seen, field.missions, field.rules, field.cells) == itself


def test_a_chariot_waits_for_the_soldier_that_boards_it(field: Board) -> None:
    soldier, chariot = field.i("soldier0"), field.i("chariot0")
    field.land("soldier0")
    field.put("soldier0", field.cell(10, 2), stop_ends=30)
    field.put("chariot0", field.cell(10, 2))
    board_mission = field.task("soldier0", K.BOARD, target=chariot)
    field.task("chariot0", K.HOLD, cell=field.cell(15, 2))
    assert field.ordered("chariot0") == Action.NULL
    field.run(400)

    assert field.pieces[soldier].carrier == chariot
    assert board_mission.state == ENDED
    assert field.pieces[chariot].cell == field.cell(15, 2)


@pytest.mark.parametrize("who", ["soldier0", "chariot0"])
def test_nobody_waits_for_the_suppressed(field: Board, who: str) -> None:
    field.land("soldier0")
    field.put("soldier0", field.cell(10, 2))
    field.put("chariot0", field.cell(10, 2))
    field.task("soldier0", K.BOARD, target=field.i("chariot0"))
    field.task("chariot0", K.HOLD, cell=field.cell(15, 2))
    field.put(who, field.cell(10, 2), suppressed=1, keep_ends=100)
    assert field.ordered("chariot0") == Action.MOVE


def test_two_soldiers_for_one_chariot_do_not_block_each_other(field: Board) -> None:
    for name in ("soldier0", "soldier1"):
        field.land(name)
        field.put(name, field.cell(10, 2))
        field.task(name, K.BOARD, target=field.i("chariot0"))
    field.put("chariot0", field.cell(10, 2))
    field.run(80)
    field.execute()

    assert field.pieces[field.i("chariot0")].passenger == field.i("soldier0")
    assert field.missions[field.i("soldier1")].state == ENDED
    assert set(field.codes) == {Code.OK}


def test_a_bombarding_chariot_stands_until_its_round_has_landed(field: Board) -> None:
    """A move before the landing would lose the round (section 9)."""
    field.put("chariot0", field.cell(10, 2))
    field.put("blue:soldier0", field.cell(29, 2), carrier=NO_PIECE)
    j = field.i("blue:soldier0")
    field.look()
    field.memory[0, j].cell, field.memory[0, j].blood = field.cell(29, 2), 3
    field.task("chariot0", K.BOMBARD, target=j)
    assert field.ordered("chariot0") == Action.INDIRECT_SHOOT
    field.run(100)
    field.memory[0, j].cell = field.cell(33, 2)  # out of range now
    field.task("chariot0", K.BOMBARD, target=j)
    assert field.ordered("chariot0") == Action.NULL
    field.run(150)
    assert field.ordered("chariot0") == Action.MOVE


def test_a_target_known_to_be_dead_ends_the_task(field: Board) -> None:
    j = meet(field, "tank0", 12)
    mission = field.task("tank0", K.ATTACK, target=j)
    field.memory[0, j].blood = 0
    field.execute()
    assert (mission.state, mission.direction) == (ENDED, 0)


def test_a_direct_order_is_kept(field: Board) -> None:
    field.task("tank0", K.HOLD, cell=field.cell(20, 10))
    field.orders[0].kind = Action.HIDE
    field.execute()
    assert field.orders[0].kind == Action.HIDE


def test_every_action_comes_out_of_some_task(board: Board, sticky: Callable[[int], Choose]) -> None:
    """All eleven actions are reachable; some games of random tasks use most of them."""
    game = type(board)(board.world, 1)
    for seed in range(20):
        other = type(board)(board.world, seed)
        other.play(1800, sticky(seed))
        game.actions += other.actions
    common = {Action.MOVE, Action.STOP, Action.HIDE, Action.OCCUPY, Action.SHOOT, Action.GET_OFF}
    assert all(game.actions[action] > 0 for action in common)
