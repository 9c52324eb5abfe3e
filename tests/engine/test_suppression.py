"""Suppression, its end, and decompressing (rule book, sections 3, 4 and 5)."""

from __future__ import annotations

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.orders import Decompress, Hide, Move, Shoot


def suppressed_by_fire(board: str, target: str, advance: int = 0, seeds: int = 400) -> Game:
    """The first game in which the shot at a piece suppresses it without loss."""
    for seed in range(seeds):
        game = Game.from_text(board, seed)
        game.advance(advance)
        game.submit("blue", Shoot("tank0", target, "GUN"))
        events = game.advance(1)
        if of_kind(events, "suppressed") and not of_kind(events, "loss"):
            return game
    raise AssertionError


def released(events: list[GameEvent]) -> list[int]:
    return [event.tick for event in of_kind(events, "released")]


def test_suppression_ends_by_itself_after_150_s() -> None:
    """Section 3: keep_left 0..150."""
    game = suppressed_by_fire("map plain-9x5\nred tank 0103\nblue tank 0303", "tank0")
    assert game.view("red").piece("tank0").suppressed_left == 149
    assert released(game.advance(300)) == [150]
    assert not game.view("red").piece("tank0").suppressed


def test_decompressing_takes_75_s_and_ends_suppression() -> None:
    """Section 4, decompress: hidden off."""
    game = Game.from_text("map plain-9x5\nred tank 0103 suppressed hidden\nblue tank 0803")
    assert game.submit("red", Decompress("tank0")) == [None]
    game.advance(1)
    assert not game.view("red").piece("tank0").hidden
    assert released(game.advance(100)) == [75]


def test_a_new_result_cancels_decompressing() -> None:
    """Section 4, decompress: a new result >= 0."""
    board = "map plain-9x5\nred tank 0103 suppressed\nblue tank 0303"
    for seed in range(100):
        game = Game.from_text(board, seed)
        game.submit("red", Decompress("tank0"))
        game.advance(10)
        game.submit("blue", Shoot("tank0", "tank0", "GUN"))
        events = game.advance(1)
        if of_kind(events, "suppressed"):
            assert game.view("red").piece("tank0").decompress_left == 0
            assert released(game.advance(300)) == [160]
            return
    raise AssertionError


def test_a_suppressed_soldier_finishes_its_hop_then_waits_with_its_path() -> None:
    """Section 5.6: it goes on when it is released."""
    board = "map plain-9x5\nred soldier 0103 moving 0203 0303\nblue tank 0503"
    game = suppressed_by_fire(board, "soldier0", advance=100)
    events = game.advance(150)
    assert [(event.kind, event.tick) for event in events] == [("arrived", 144), ("released", 250)]
    assert game.view("red").piece("soldier0").path == ("0303",)
    assert [event.tick for event in game.advance(200)] == [250 + 144]


def test_a_suppressed_vehicle_drives_on() -> None:
    """Section 5.6 holds soldiers only."""
    game = suppressed_by_fire(
        "map plain-9x5\nred tank 0103 moving 0203 0303\nblue tank 0503", "tank0", advance=5
    )
    assert [event.tick for event in of_kind(game.advance(60), "arrived")] == [20, 40]


def test_a_suppressed_vehicle_shoots_with_minus_1_and_a_suppressed_soldier_not() -> None:
    """Sections 4 and 7."""
    game = Game.from_text(
        "map plain-9x5\nred tank 0103 suppressed\nred soldier 0103 suppressed\nblue tank 0303"
    )
    assert game.why_illegal("red", Shoot("tank0", "tank0", "GUN")) is None
    assert game.why_illegal("red", Shoot("soldier0", "tank0", "ROCKET")) is not None


def test_a_suppressed_soldier_that_got_a_path_in_the_same_step_waits() -> None:
    """Sections 5.2 and 5.4: orders start before the fire is applied."""
    for seed in range(200):
        game = Game.from_text("map plain-9x5\nred soldier 0103\nblue tank 0303", seed)
        game.submit("red", Move("soldier0", ["0203"]))
        game.submit("blue", Shoot("tank0", "soldier0", "GUN"))
        events = game.advance(1)
        if of_kind(events, "suppressed"):
            assert of_kind(game.advance(149), "arrived") == []
            assert game.view("red").piece("soldier0").path == ("0203",)
            return
    raise AssertionError


def test_a_waiting_soldier_decompresses_and_goes_on() -> None:
    """Section 4, decompress: path empty or progress = 0."""
    game = Game.from_text("map plain-9x5\nred soldier 0103 suppressed moving 0203\nblue tank 0903")
    assert game.view("red").piece("soldier0").speed == 0
    assert game.submit("red", Decompress("soldier0")) == [None]
    events = game.advance(75 + 144)
    assert [(event.kind, event.tick) for event in events] == [("released", 75), ("arrived", 75 + 144)]


def test_suppression_does_not_end_cover() -> None:
    """Section 13: hidden does not end on being hit."""
    board = "map plain-9x5\nred tank 0103 hidden\nblue tank 0203"
    assert suppressed_by_fire(board, "tank0").view("red").piece("tank0").hidden


def test_a_suppressed_piece_may_not_hide_but_a_natural_stop_is_no_hindrance() -> None:
    """Section 4, hide."""
    game = Game.from_text("map plain-9x5\nred tank 0103 stopping\nred tank 0101 suppressed\nblue tank 0903")
    assert game.why_illegal("red", Hide("tank0")) is None
    assert game.why_illegal("red", Hide("tank1")) is not None


def test_a_soldier_that_is_suppressed_first_in_a_step_loses_no_squad_by_its_0() -> None:
    """Section 5.4: only a soldier that was suppressed in the state at the start of the step."""
    board = "map plain-9x5\nred soldier 0103\nblue tank 0303\nblue chariot 0303"
    for seed in range(400):
        game = Game.from_text(board, seed)
        game.submit("blue", [Shoot("tank0", "soldier0", "GUN"), Shoot("chariot0", "soldier0", "CANNON")])
        events = game.advance(1)
        if [event.result for event in of_kind(events, "shot")] == [0, 0]:
            assert not of_kind(events, "loss")
            return
    raise AssertionError
