"""What pieces did, they were about: the tasks of a person's game, of which the orders alone are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.orders import (
    Decompress,
    GetOff,
    GetOn,
    GuideShoot,
    Hide,
    IndirectShoot,
    Occupy,
    Order,
    Shoot,
)
from hexwar_sb3.engine.records import NEVER
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.engine.state import State, new_state
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.play.hindsight import Deeds, Hindsight, read_task
from hexwar_sb3.play.recorded import Aim
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.records import TaskKind

DECISION, NEXT = 75, 150  # ticks
POINT = "3635"  # a control point of "plain"


@pytest.fixture(scope="module")
def world() -> World:
    return load_world("plain")


class Told:
    """A game of which a test tells what a piece of red did."""

    def __init__(self, world: World) -> None:
        self.world, self.roster, self.deeds = world, Roster(world.scenario), Deeds(world.n_pieces)
        self.state: State = new_state(world, 1)
        self.deeds.note_pieces(0, self.state.pieces[0])
        self.state.pieces[0].arrives_at = 20  # everybody sets out
        self.deeds.note_pieces(1, self.state.pieces[0])

    def stands(self, piece: str, cell: str, since: int, until: int = NEVER) -> None:
        """A piece comes to a cell and goes on, or stays there."""
        row = self.state.pieces[0, self.roster.index(f"red:{piece}")]
        row.cell, row.arrives_at = self.roster.cell(cell), NEVER
        self.deeds.note_pieces(since, self.state.pieces[0])
        if until < NEVER:
            row.arrives_at = until + 20
            self.deeds.note_pieces(until, self.state.pieces[0])

    def orders(self, tick: int, order: Order) -> None:
        self.deeds.note_order(self.roster.index(f"red:{order.piece}"), tick, order)

    def aims(self, piece: str) -> list[Aim]:
        """What a piece is about from the decision on."""
        aims = Hindsight(self.world, Camp.RED, self.deeds).at(DECISION, NEXT, self.state.memory[0, Camp.RED])
        return aims[self.roster.index(f"red:{piece}")]

    def at(self, kind: TaskKind, cell: str) -> Aim:
        return Aim(kind, cell=int(self.roster.cell(cell)))

    def against(self, kind: TaskKind, piece: str) -> Aim:
        return Aim(kind, target=int(self.roster.index(piece)))


@pytest.fixture
def told(world: World) -> Told:
    return Told(world)


def test_a_piece_is_about_the_place_where_it_will_stand(told: Told) -> None:
    """Not those that it passes, nor where it stops for less time than a stop takes."""
    told.stands("tank0", "1535", 80, 120)
    told.stands("tank0", "2035", 200, 270)
    told.stands("tank0", "2535", 400, 480)
    told.stands("tank0", "3035", 600)

    assert told.aims("tank0") == [told.at(TaskKind.HOLD, "2535")]


def test_a_piece_that_goes_on_before_the_next_decision_is_about_its_next_place(told: Told) -> None:
    told.stands("tank0", "1535", 20, 140)
    told.stands("tank0", "2535", 400)

    assert told.aims("tank0") == [told.at(TaskKind.HOLD, "2535")]


def test_a_piece_that_dies_or_is_still_under_way_is_about_its_last_cell(told: Told) -> None:
    told.stands("tank0", "1535", 80, 90)

    assert told.aims("tank0") == [told.at(TaskKind.HOLD, "1535")]


@pytest.mark.parametrize(
    ("order", "kind"), [(Hide("tank0"), TaskKind.HIDE), (Occupy("tank0"), TaskKind.HOLD)]
)
def test_what_it_does_where_it_will_stand_is_the_task(told: Told, order: Order, kind: TaskKind) -> None:
    told.stands("tank0", "2535", 400)
    told.orders(410, order)

    assert told.aims("tank0")[0] == told.at(kind, "2535")


def test_a_piece_that_hid_hides_on(told: Told) -> None:
    told.stands("tank0", "1535", 10)
    told.orders(20, Hide("tank0"))

    assert told.aims("tank0")[0] == told.at(TaskKind.HIDE, "1535")


def test_soldiers_board_and_are_set_down(told: Told) -> None:
    told.stands("soldier0", "2535", 300)
    told.orders(310, GetOn("soldier0", "chariot0"))
    told.stands("chariot0", "2535", 300)
    told.orders(320, GetOff("chariot0", "soldier0"))
    told.orders(330, Hide("chariot0"))

    assert told.aims("soldier0")[0] == told.against(TaskKind.BOARD, "red:chariot0")
    assert told.aims("chariot0")[0] == told.at(TaskKind.DROP, "2535")


def test_who_was_set_down_before_is_not_set_down_again(told: Told) -> None:
    told.stands("chariot0", "2535", 10)
    told.orders(20, GetOff("chariot0", "soldier0"))

    assert told.aims("chariot0") == [told.at(TaskKind.HOLD, "2535")]


@pytest.mark.parametrize(
    ("order", "kind"),
    [
        (Shoot("tank0", "tank1", "GUN"), TaskKind.ATTACK),
        (GuideShoot("tank0", "tank1", "chariot0"), TaskKind.GUIDE),
    ],
)
def test_a_shot_before_the_next_decision_is_an_attack_but_not_in_a_control_point(
    told: Told, order: Order, kind: TaskKind
) -> None:
    told.stands("tank0", "2535", 80)
    told.orders(DECISION + 10, order)
    assert told.aims("tank0") == [told.against(kind, "blue:tank1"), told.at(TaskKind.HOLD, "2535")]

    told.stands("tank0", POINT, 85)
    assert told.aims("tank0") == [told.at(TaskKind.HOLD, POINT), told.against(kind, "blue:tank1")]


@pytest.mark.parametrize("tick", [DECISION - 1, NEXT])
def test_a_shot_at_another_time_says_nothing(told: Told, tick: int) -> None:
    told.stands("tank0", "2535", 10)
    told.orders(tick, Shoot("tank0", "tank1", "GUN"))

    assert told.aims("tank0") == [told.at(TaskKind.HOLD, "2535")]


def test_a_mortar_round_is_for_the_known_enemy_that_is_nearest(told: Told) -> None:
    told.stands("chariot0", "2535", 10)
    told.orders(DECISION, IndirectShoot("chariot0", "3035"))
    assert told.aims("chariot0")[0].kind == TaskKind.BOMBARD
    assert told.aims("chariot0")[0].target == -1  # nobody is known: no task is against nobody

    memory: Any = told.state.memory[0, Camp.RED]
    for piece, cell in (("blue:tank0", "3039"), ("blue:tank1", "3036")):
        known = memory[told.roster.index(piece)]
        known.cell, known.blood = told.roster.cell(cell), 1
    assert told.aims("chariot0")[0] == told.against(TaskKind.BOMBARD, "blue:tank1")


def test_who_comes_out_of_suppression_recovers(told: Told) -> None:
    told.orders(DECISION + 5, Decompress("tank0"))

    assert told.aims("tank0")[0] == Aim(TaskKind.RECOVER)


def test_every_task_that_a_record_may_have_is_read(world: World) -> None:
    roster = Roster(world.scenario)
    assert read_task("stop", roster) == Aim(TaskKind.STOP)
    assert read_task("hold 1134", roster) == Aim(TaskKind.HOLD, cell=int(roster.cell("1134")))
    assert read_task("attack blue:tank0", roster) == Aim(
        TaskKind.ATTACK, target=int(roster.index("blue:tank0"))
    )


@pytest.mark.parametrize("text", ["hold", "stop 1134", "fly 1134", "hold 9999", "attack tank9", "attack", ""])
def test_what_is_no_task_is_refused(world: World, text: str) -> None:
    with pytest.raises(HexWarError):
        read_task(text, Roster(world.scenario))


def test_a_time_without_an_end_is_no_number_of_ticks(told: Told) -> None:
    """The last place of a piece lasts for ever, whatever the length of the game."""
    aims = Hindsight(told.world, Camp.RED, told.deeds).at(1799, 1875, told.state.memory[0, Camp.RED])

    assert np.all([len(own) == 1 for own in aims])
