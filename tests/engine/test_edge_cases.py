"""The edge cases of section 13 that no other page of these tests has."""

from __future__ import annotations

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import GetOn, GuideShoot, Move, Occupy, Shoot


def test_a_missile_of_an_aerocraft_reaches_farther_than_it_sees() -> None:
    """Section 13: intended; it fires at what it sees itself."""
    game = Game.from_text("map plain-20x3\nred aerocraft 0102\nred tank 0202\nblue tank 0902")
    assert "blue:tank0" in game.view("red").piece("tank0").sees
    why = "blue tank0 is not in sight of red aerocraft0; a target must be alive and seen by red aerocraft0 itself"
    assert game.why_illegal("red", Shoot("aerocraft0", "tank0", "AIRM")) == why


def test_a_target_that_went_aboard_is_gone() -> None:
    """Section 13: the order is refused (code target_gone), no ammunition is spent."""
    game = Game.from_text("map plain-9x3\nred tank 0102\nblue chariot 0402\nblue soldier 0402")
    game.submit("blue", GetOn("soldier0", "chariot0"))
    game.advance(74)
    assert game.why_illegal("red", Shoot("tank0", "soldier0", "GUN")) is None
    game.advance(1)
    assert game.submit("red", Shoot("tank0", "soldier0", "GUN"), strict=False) != [None]
    game.advance(1)
    assert dict(game.view("red").piece("tank0").ammo)["GUN"] == 30


def test_a_piece_without_ammunition_can_still_move_occupy_guide_and_see() -> None:
    """Section 13: its weapons are not listed."""
    game = Game.from_text("""
        map   plain-20x3
        point main 0102 80
        red   chariot 0302
        red   soldier 0102 ammo PORT 0 ammo SMALL 0
        blue  tank 0602
    """)
    orders = game.legal_orders("red", "soldier0")
    assert {type(order) for order in orders} >= {Move, Occupy, GuideShoot}
    assert not any(isinstance(order, Shoot) for order in orders)
    assert game.view("red").piece("soldier0").sees == ("blue:tank0",)


def test_a_destroyed_piece_is_out_of_the_game() -> None:
    """Section 12: it counts nothing, sees nothing and stands nowhere."""
    game = Game.from_text("map plain-9x3\npoint main 0402 80\nred tank 0102 blood 0\nblue tank 0402")
    assert game.view("red").piece("tank0").sees == ()
    assert game.view("red").seen == ()
    game.submit("blue", Occupy("tank0"))
    game.advance(1)
    assert game.margin("blue") == 30 + 80
