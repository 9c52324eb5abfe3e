"""Control points (rule book, sections 4, 5.5, 12 and 13)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import of_kind
from hexwar_sb3.engine.orders import Move, Occupy, Shoot, Stop


def owner(game: Game) -> str:
    return game.view("red").points[0].owner


def test_control_points_start_green() -> None:
    """Section 3."""
    assert {point.owner for point in Game("plain").view("blue").points} == {"green"}


@pytest.mark.parametrize("words", ["", "suppressed", "stopping", "stopped", "moving 0403"])
def test_a_point_is_occupied_in_any_transition(words: str) -> None:
    """Section 4, occupy: while suppressed, with a path, in any transition, the forced stop too."""
    game = Game.from_text(f"map plain-9x5\npoint main 0303 80\nred tank 0303 {words}\nblue tank 0903")
    assert game.submit("red", Occupy("tank0")) == [None]
    assert [event.kind for event in of_kind(game.advance(1), "occupied")] == ["occupied"]
    assert owner(game) == "red"


def test_a_soldier_occupies_as_soon_as_it_arrives() -> None:
    """Section 4, occupy: progress = 0."""
    game = Game.from_text("map plain-9x5\npoint main 0303 80\nred soldier 0203 moving 0303\nblue tank 0903")
    game.advance(143)
    assert game.why_illegal("red", Occupy("soldier0")) is not None
    game.advance(1)
    assert game.submit("red", Occupy("soldier0")) == [None]


@pytest.mark.parametrize(
    "enemy", ["soldier 0303", "soldier 0203", "soldier 0202", "tank 0304", "chariot 0403 hidden"]
)
def test_no_point_is_occupied_beside_a_living_enemy(enemy: str) -> None:
    """Section 4, occupy: in the cell and its 6 neighbours; seen or not."""
    game = Game.from_text(
        f"map plain-9x5\npoint main 0303 80\nred tank 0303\nblue {enemy.replace('0303', '0903')}"
    )
    if "0303" in enemy:
        with game.edit() as state:
            state["blue:soldier0"].cell = "0303"
        game.pieces[0].cell = game.pieces[1].cell
    game.submit("red", Occupy("tank0"), strict=False)
    game.advance(1)
    assert owner(game) == "green"


@pytest.mark.parametrize("enemy", ["aerocraft 0303", "tank 0503", "soldier 0403 blood 0"])
def test_who_does_not_hinder_occupying(enemy: str) -> None:
    """Section 4, occupy: aerocraft, enemies two cells away, and the dead do not."""
    game = Game.from_text(f"map plain-9x5\npoint main 0303 80\nred tank 0303\nblue {enemy}\nblue tank 0903")
    game.submit("red", Occupy("tank0"))
    game.advance(1)
    assert owner(game) == "red"


def test_occupying_is_judged_against_the_survivors_of_the_step() -> None:
    """Section 5.5: the enemy beside the point dies in the same step."""
    board = "map plain-9x5\npoint main 0303 80\nred tank 0303\nred tank 0203\nblue soldier 0403 blood 1"
    for seed in range(300):
        game = Game.from_text(board, seed)
        game.submit("red", [Occupy("tank0"), Shoot("tank1", "soldier0", "GUN")])
        died = bool(of_kind(game.advance(1), "dead"))
        assert (owner(game) == "red") == died
        if died:
            return
    raise AssertionError


def test_a_piece_that_dies_in_the_step_occupies_nothing() -> None:
    """Section 5.5: pieces still alive."""
    board = "map plain-9x5\npoint main 0303 80\nred soldier 0303 blood 1\nblue tank 0503"
    for seed in range(300):
        game = Game.from_text(board, seed)
        game.submit("red", Occupy("soldier0"))
        game.submit("blue", Shoot("tank0", "soldier0", "GUN"))
        if of_kind(game.advance(1), "dead"):
            assert owner(game) == "green"
            return
    raise AssertionError


def test_both_camps_beside_a_point_block_each_other() -> None:
    """Sections 5.5 and 13: neither succeeds, the point keeps its camp."""
    game = Game.from_text("map plain-9x5\npoint main 0303 80 blue\nred tank 0303\nblue tank 0403")
    game.submit("red", Occupy("tank0"))
    game.advance(1)
    assert owner(game) == "blue"


def test_a_point_stays_with_its_camp_after_the_holder_leaves_or_dies() -> None:
    """Section 13."""
    game = Game.from_text(
        "map plain-9x5\npoint main 0303 80 red\nred tank 0303\nred tank 0203\nblue tank 0903"
    )
    game.submit("red", Move("tank0", ["0403", "0503"]))
    game.advance(100)
    assert owner(game) == "red"
    with game.edit() as state:
        state["red:tank0"].blood = 0
    game.advance(10)
    assert owner(game) == "red"


def test_a_piece_that_stops_on_a_point_occupies_it_without_delay() -> None:
    """Section 4: stop, then occupy in the forced transition."""
    game = Game.from_text("map plain-9x5\npoint main 0303 80\nred tank 0303 moving 0403\nblue tank 0903")
    game.submit("red", Stop("tank0"))
    game.advance(1)
    assert game.submit("red", Occupy("tank0")) == [None]
    game.advance(1)
    assert owner(game) == "red"


def test_taking_a_neutral_point_is_worth_twice_its_value_to_the_taker() -> None:
    """Section 12, eq. (1) read literally: +160 / 0; retaking it +160 / -160."""
    game = Game.from_text("map plain-9x5\npoint main 0303 80\nred tank 0303\nblue tank 0903")
    start = {camp: game.margin(camp) for camp in ("red", "blue")}
    assert start == {"red": -80, "blue": -80}
    game.submit("red", Occupy("tank0"))
    game.advance(1)
    assert (game.margin("red"), game.margin("blue")) == (80, -80)
    with game.edit() as state:
        state["main"].owner = "blue"
    assert (game.margin("red"), game.margin("blue")) == (-80, 80)
