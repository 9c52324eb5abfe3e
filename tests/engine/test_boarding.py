"""Getting on and off, and what happens to passengers (rule book, sections 4 and 13)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import of_kind
from hexwar_sb3.engine.orders import GetOff, GetOn, Move, Shoot

CARRIED = "map plain-9x5\nred chariot 0303{chariot}\nred soldier aboard chariot0\nblue tank 0503\n"
BESIDE = "map plain-9x5\nred chariot 0303{chariot}\nred soldier 0303{soldier}\nblue tank 0503\n"


def test_getting_on_takes_75_s_and_both_are_busy() -> None:
    """Section 4, get-on."""
    game = Game.from_text(BESIDE.format(chariot=" hidden", soldier=" hidden"))
    assert game.submit("red", GetOn("soldier0", "chariot0")) == [None]
    game.advance(1)
    red = game.view("red")
    assert [red.piece(name).doing for name in ("chariot0", "soldier0")] == ["getting on", "getting on"]
    assert [red.piece(name).hidden for name in ("chariot0", "soldier0")] == [False, False]
    assert [(event.kind, event.tick) for event in game.advance(80)] == [("aboard", 75)]
    assert game.view("red").piece("soldier0").aboard == "chariot0"
    assert game.view("red").piece("chariot0").passenger == "soldier0"
    assert "red:soldier0" not in [enemy.name for enemy in game.view("blue").seen]


def test_getting_off_takes_75_s_and_the_soldier_stands_settled() -> None:
    """Section 4, get-off."""
    game = Game.from_text(CARRIED.format(chariot=""))
    assert game.submit("red", GetOff("chariot0", "soldier0")) == [None]
    assert [(event.kind, event.tick) for event in game.advance(80)] == [("off", 75)]
    soldier = game.view("red").piece("soldier0")
    assert (soldier.aboard, soldier.cell, soldier.doing) == (None, "0303", "settled")
    assert "red:soldier0" in [enemy.name for enemy in game.view("blue").seen]


def test_a_passenger_rides_along() -> None:
    """Section 2: carrying is what chariots are for."""
    game = Game.from_text(CARRIED.format(chariot=""))
    game.submit("red", Move("chariot0", ["0203", "0103"]))
    game.advance(40)
    assert game.view("red").piece("soldier0").cell == "0103"


def test_a_soldier_gets_on_any_chariot_of_its_camp() -> None:
    """Section 4, get-on: not only its home."""
    game = Game.from_text(BESIDE.format(chariot="", soldier="") + "red chariot 0303")
    assert game.why_illegal("red", GetOn("soldier0", "chariot1")) is None


def test_a_soldier_waits_aboard_where_the_cell_filled_up() -> None:
    """Section 13: event getoff_blocked."""
    game = Game.from_text(CARRIED.format(chariot="") + "red tank 0303\nred tank 0303\nred tank 0203")
    game.submit("red", [GetOff("chariot0", "soldier0"), Move("tank2", ["0303"])])
    events = game.advance(80)
    assert [event.kind for event in events] == ["arrived", "getoff_blocked"]
    assert game.view("red").piece("soldier0").aboard == "chariot0"
    assert game.view("red").piece("chariot0").doing == "settled"


def shoot_until(
    board: str, camp: str, done: str, orders: list[GetOn | GetOff], losses: int | None = None
) -> Game:
    """A game in which the enemy's shot at the chariot had the wanted effect on it."""
    for seed in range(500):
        game = Game.from_text(board, seed)
        game.submit(camp, orders)
        game.advance(10)
        game.submit("blue", Shoot("tank0", "chariot0", "GUN"))
        events = game.advance(1)
        lost = [event.losses for event in of_kind(events, "loss") if event.piece == "red:chariot0"]
        if of_kind(events, done) and (losses is None or lost == [losses]):
            return game
    raise AssertionError


@pytest.mark.parametrize("losses", [1, 2])
def test_a_passenger_loses_as_many_squads_as_its_chariot_vehicles(losses: int) -> None:
    """Section 13."""
    game = shoot_until(CARRIED.format(chariot=""), "red", "suppressed", [], losses)
    assert game.view("red").piece("soldier0").blood == 3 - losses
    assert not game.view("red").piece("soldier0").suppressed


def test_a_passenger_dies_with_its_chariot() -> None:
    """Section 13."""
    game = shoot_until(CARRIED.format(chariot=""), "red", "dead", [])
    assert [piece.blood for piece in game.view("red").own] == [0, 0]


def test_a_soldier_that_is_getting_off_dies_with_its_chariot() -> None:
    """Section 13: off: it was still aboard."""
    game = shoot_until(CARRIED.format(chariot=""), "red", "dead", [GetOff("chariot0", "soldier0")])
    assert [piece.blood for piece in game.view("red").own] == [0, 0]


def test_a_soldier_that_is_getting_on_survives_its_chariot() -> None:
    """Section 13: on: it is still in the cell, free."""
    game = shoot_until(BESIDE.format(chariot="", soldier=""), "red", "dead", [GetOn("soldier0", "chariot0")])
    soldier = game.view("red").piece("soldier0")
    assert (soldier.blood, soldier.doing, soldier.aboard) == (3, "settled", None)


def test_suppression_cancels_boarding_for_both() -> None:
    """Section 13: the soldier stays where it was."""
    game = shoot_until(
        BESIDE.format(chariot="", soldier=""), "red", "suppressed", [GetOn("soldier0", "chariot0")]
    )
    assert [piece.doing for piece in game.view("red").own] == ["settled", "settled"]
    game = shoot_until(CARRIED.format(chariot=""), "red", "suppressed", [GetOff("chariot0", "soldier0")])
    assert game.view("red").piece("soldier0").aboard == "chariot0"
    assert game.view("red").piece("chariot0").board_left == 0


def test_the_timers_of_a_passenger_run_on() -> None:
    """Section 13: and it keeps its ammunition."""
    game = Game.from_text(CARRIED.format(chariot=""))
    with game.edit() as state:
        state["red:soldier0"].cool = 30
        state["red:soldier0"].ammo = {"PORT": 2}
    game.advance(40)
    soldier = game.view("red").piece("soldier0")
    assert (soldier.cool_left, dict(soldier.ammo)["PORT"]) == (0, 2)


def test_a_passenger_is_no_target() -> None:
    """Section 13: never targeted."""
    game = Game.from_text(CARRIED.format(chariot=""))
    why = "red soldier0 is not in sight of blue tank0; a target must be alive and seen by blue tank0 itself"
    assert game.why_illegal("blue", Shoot("tank0", "soldier0", "GUN")) == why
