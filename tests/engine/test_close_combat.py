"""Close combat: ground pieces of both camps in one cell (rule book, section 10)."""

from __future__ import annotations

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.orders import GetOn, Hide, IndirectShoot, Move, Occupy, Shoot

BOARD = """
    map  plain-9x5
    {cells}
    red  {red} 0303
    blue {blue} 0503
    {more}
"""


def meet(red: str, blue: str, more: str = "", cells: str = "", seed: int = 0) -> Game:
    """A game in which the first pieces of both camps have just met in 0403."""
    game = Game.from_text(BOARD.format(red=red, blue=blue, more=more, cells=cells), seed)
    with game.edit() as state:
        for camp, kind in (("red", red), ("blue", blue)):
            state[f"{camp}:{kind}0"].cell = "0403"
    return game


def shots(events: list[GameEvent], kind: str = "close_shot") -> list[tuple[int, str, str | None]]:
    return [(event.tick, event.piece, event.target) for event in of_kind(events, kind)]


def test_first_contact_stops_everybody_in_the_cell() -> None:
    """Section 5.7: paths cleared, transitions cancelled; the first exchange is in the step after."""
    game = Game.from_text("map plain-9x5\nred tank 0303 moving 0403 0503\nblue chariot 0403")
    game.submit("blue", Hide("chariot0"))
    events = game.advance(20)
    assert [(event.kind, event.tick) for event in events] == [("arrived", 20), ("first_contact", 20)]
    assert game.view("red").fights == ("0403",)
    assert game.view("red").piece("tank0").path == ()
    assert game.view("blue").piece("chariot0").hide_left == 0
    assert shots(game.advance(1)) == [(21, "red:tank0", "blue:chariot0"), (21, "blue:chariot0", "red:tank0")]


def test_exchanges_follow_every_75_s() -> None:
    """Section 10, interval."""
    for seed in range(50):
        game = meet("tank", "tank", seed=seed)
        events = game.advance(160)
        if len(shots(events)) == 6:
            assert [tick for tick, *_ in shots(events)] == [1, 1, 76, 76, 151, 151]
            return
    raise AssertionError


def test_everybody_fires_in_an_exchange_hot_suppressed_or_just_moved() -> None:
    """Section 10: ignoring cool-down and suppression of the shooter; the -1 stays."""
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].suppressed = True
        state["red:soldier0"].cool = 50
    event = of_kind(game.advance(1), "close_shot")[0]
    assert (event.piece, event.modifiers, event.cells_apart) == ("red:soldier0", -1, 0)


def test_the_weapon_of_the_best_level_is_fired_and_spent() -> None:
    """Section 10: best level at distance 0, ammunition needed."""
    game = meet("soldier", "tank")
    event = of_kind(game.advance(1), "close_shot")[0]
    assert (event.weapon, event.level) == ("PORT", 7)
    assert dict(game.view("red").piece("soldier0").ammo)["PORT"] == 3
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].ammo = {"PORT": 0, "ROCKET": 0}
    assert [event.piece for event in of_kind(game.advance(1), "close_shot")] == ["blue:tank0"]


def test_the_target_is_a_tank_before_a_chariot_before_a_soldier_then_the_weakest() -> None:
    """Section 10: target."""
    more = "blue chariot 0503\nblue tank 0503\nblue tank 0503 blood 2"
    game = Game.from_text(BOARD.format(red="tank", blue="soldier", more=more, cells=""))
    with game.edit() as state:
        for name in ("red:tank0", "blue:soldier0", "blue:chariot0"):
            state[name].cell = "0403"
    assert shots(game.advance(1))[0] == (1, "red:tank0", "blue:chariot0")
    game = Game.from_text(BOARD.format(red="tank", blue="soldier", more=more, cells=""))
    with game.edit() as state:
        for name in ("red:tank0", "blue:soldier0", "blue:tank0", "blue:tank1"):
            state[name].cell = "0403"
    assert shots(game.advance(1))[0] == (1, "red:tank0", "blue:tank1")


def test_a_piece_leaves_under_one_shot_of_every_enemy_there() -> None:
    """Section 10: exit shots in step 3; after it the leaver is out of the exchanges, and free on arrival."""
    for seed in range(200):
        game = meet("tank", "tank", more="blue chariot 0503", seed=seed)
        with game.edit() as state:
            state["blue:chariot0"].cell = "0403"
        game.advance(5)
        if game.pieces[0].blood == 0 or game.pieces[1:].blood.min() == 0:
            continue
        assert game.submit("red", Move("tank0", ["0303"])) == [None]
        left = {(6, "blue:tank0", "red:tank0"), (6, "blue:chariot0", "red:tank0")}
        assert set(shots(game.advance(1), "exit_shot")) == left
        if game.pieces[0].blood == 0:
            continue
        later = game.advance(80)
        assert not shots(later)
        assert [event.cell for event in of_kind(later, "arrived")] == ["0303"]
        assert game.view("red").fights == ()
        assert game.why_illegal("red", Move("tank0", ["0203"])) is None
        return
    raise AssertionError


def test_a_suppressed_soldier_cannot_leave() -> None:
    """Section 10."""
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].suppressed = True
    why = "red soldier0 is suppressed for 149 more s; it must be free before it moves"
    assert game.why_illegal("red", Move("soldier0", ["0303"])) == why


def test_whoever_comes_late_changes_neither_the_clock_nor_a_path() -> None:
    """Section 5.7: a newcomer to a running close combat."""
    for seed in range(80):
        game = meet("tank", "tank", more="red chariot 0203 moving 0303 0403", seed=seed)
        events = game.advance(90)
        if len(shots(events)) >= 5 and not of_kind(events, "dead"):
            assert {tick for tick, *_ in shots(events)} == {1, 76}
            assert "red:chariot0" in [piece for _, piece, _ in shots(events)]
            assert len(of_kind(events, "first_contact")) <= 1
            return
    raise AssertionError


def test_the_fight_ends_when_only_one_camp_is_left() -> None:
    """Section 10: the survivors are free."""
    for seed in range(200):
        game = meet("tank", "soldier", seed=seed)
        with game.edit() as state:
            state["blue:soldier0"].blood = 1
        events = game.advance(200)
        if "blue:soldier0" in [event.piece for event in of_kind(events, "dead")]:
            assert game.view("red").fights == ()
            assert game.why_illegal("red", Move("tank0", ["0303"])) is None
            return
    raise AssertionError


def test_a_round_judges_pieces_in_close_combat() -> None:
    """Section 10: mortar rounds judge all."""
    for seed in range(300):
        game = Game.from_text("map plain-20x5\nred chariot 0103\nred tank 0803\nblue tank 1003", seed)
        game.submit("red", IndirectShoot("chariot0", "0903"))
        game.advance(140)
        with game.edit() as state:
            state["red:tank0"].cell = state["blue:tank0"].cell = "0903"
        events = game.advance(10)
        if of_kind(events, "mortar_landed")[0].cell == "0903" and not of_kind(events, "dead"):
            judged = {event.target for event in of_kind(events, "mortar_judged")}
            assert judged == {"red:tank0", "blue:tank0"}
            return
    raise AssertionError


def test_a_point_in_close_combat_is_occupied_by_nobody() -> None:
    """Section 10: the enemy is there."""
    game = meet("tank", "tank", cells="point main 0403 80")
    for camp in ("red", "blue"):
        why = f"{camp} tank0 is in close combat; it can only move out to a cell free of enemies"
        assert game.why_illegal(camp, Occupy("tank0")) == why


def test_close_combat_cancels_boarding() -> None:
    """Section 13: for both partners; the soldier stays where it was."""
    game = Game.from_text("map plain-9x5\nred chariot 0403\nred soldier 0403\nblue tank 0503")
    game.submit("red", GetOn("soldier0", "chariot0"))
    game.submit("blue", Move("tank0", ["0403"]))
    game.advance(20)
    assert game.view("red").piece("soldier0").doing == game.view("red").piece("chariot0").doing == "settled"
    game.advance(80)
    assert game.view("red").piece("soldier0").aboard is None


def test_an_aerocraft_above_a_fight_takes_no_part() -> None:
    """Section 13: it may share a cell with enemies."""
    game = meet("tank", "soldier", more="red aerocraft 0303\nblue aerocraft 0503")
    with game.edit() as state:
        state["red:aerocraft0"].cell = state["blue:aerocraft0"].cell = "0403"
    pieces = {piece for _, piece, _ in shots(game.advance(2))}
    assert pieces <= {"red:tank0", "blue:soldier0"}
    assert game.why_illegal("red", Shoot("aerocraft0", "soldier0", "AIRM")) is not None, (
        "no fire into the fight"
    )
