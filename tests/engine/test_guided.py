"""Guided fire (rule book, sections 8 and 13)."""

from __future__ import annotations

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import of_kind
from hexwar_sb3.engine.orders import GuideShoot, Shoot

GUIDED = "map plain-40x5\nred chariot 0103{chariot}\nred soldier 0503\nblue tank 0903{tank}\n{more}"


def test_a_guided_shot_is_fired_by_the_chariot() -> None:
    """Section 8: its blood, place, suppression and rounds; cool = 75 for both, cover of the chariot only."""
    board = GUIDED.format(chariot=" hidden suppressed", tank="", more="")
    game = Game.from_text(board)
    with game.edit() as state:
        state["red:soldier0"].hidden = True
    assert game.submit("red", GuideShoot("soldier0", "tank0", "chariot0")) == [None]
    event = of_kind(game.advance(1), "guided")[0]
    assert (event.shooter, event.weapon, event.level, event.modifiers) == ("red:chariot0", "HEAVY", 8, -1)
    assert event.cells_apart == 8
    red = game.view("red")
    assert (red.piece("chariot0").cool_left, red.piece("soldier0").cool_left) == (74, 74)
    assert (red.piece("chariot0").hidden, red.piece("soldier0").hidden) == (False, True)
    assert dict(red.piece("chariot0").ammo)["HEAVY"] == 5


def test_a_guided_chariot_need_not_see_the_target() -> None:
    """Section 4, guide-shoot: line of sight of the chariot is not needed."""
    wall = "cell 0301 0302 0303 0304 0305 elev 200"
    game = Game.from_text(GUIDED.format(chariot="", tank="", more=wall))
    assert "blue:tank0" not in game.view("red").piece("chariot0").sees
    assert game.why_illegal("red", GuideShoot("soldier0", "tank0", "chariot0")) is None


def test_an_aerocraft_guides_for_any_chariot() -> None:
    """Section 4, guide-shoot."""
    game = Game.from_text(GUIDED.format(chariot="", tank="", more="red aerocraft 0703\nred chariot 0102"))
    for chariot in ("chariot0", "chariot1"):
        assert game.why_illegal("red", GuideShoot("aerocraft0", "tank0", chariot)) is None


def test_a_chariot_may_fire_its_missiles_itself() -> None:
    """Section 13: HEAVY may also be fired directly."""
    game = Game.from_text(GUIDED.format(chariot="", tank="", more=""))
    assert game.why_illegal("red", Shoot("chariot0", "tank0", "HEAVY")) is None


def test_a_guided_shot_counts_though_its_guider_dies_in_the_same_step() -> None:
    """Section 8: both read the state at the start."""
    for seed in range(300):
        game = Game.from_text(GUIDED.format(chariot="", tank="", more=""), seed)
        with game.edit() as state:
            state["red:soldier0"].blood = 1
        game.submit("red", GuideShoot("soldier0", "tank0", "chariot0"))
        game.submit("blue", Shoot("tank0", "soldier0", "GUN"))
        events = game.advance(1)
        guided = of_kind(events, "guided")[0]
        if (guided.result or 0) > 0 and "red:soldier0" in [e.piece for e in of_kind(events, "dead")]:
            assert game.pieces[2].blood < 3
            return
    raise AssertionError("never both")
