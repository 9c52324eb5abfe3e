"""A game against a seated opponent: what a person orders is played as if a bot had ordered it, at any pace."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hexwar_sb3 as hx
from hexwar_sb3.engine import game as by_orders
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.game import Game
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.rules.enums import Camp


def told(game: by_orders.Game) -> str:
    return state_hash(game.state, 0)


def orders_of(replay: hx.Replay, camp: str) -> dict[int, list[str]]:
    """What a camp ordered, by tick; those that were refused are in it."""
    lines = [line for line in replay.lines if line["type"] == "orders" and line["camp"] == camp]
    return {line["tick"]: [*line["orders"], *(order for order, _ in line["refused"])] for line in lines}


@pytest.mark.parametrize("opponent", ["MA2", "drawn-plan:5", "HRL0"])
@pytest.mark.parametrize("side", ["red", "blue"])
def test_orders_by_hand_are_played_as_a_bots(opponent: str, side: str) -> None:
    """MA1's orders of a recorded game, given by hand, lead to the same game; decisions are in the replay too."""
    pair = ("MA1", opponent) if side == "red" else (opponent, "MA1")
    replay = record_game(*pair, seed=3)
    game = Game("plain", seed=replay.seed, opponent=opponent, side=side)
    for tick, orders in orders_of(replay, side).items():
        game.advance(tick - game.tick)
        game.submit(side, orders, strict=False)
    game.advance(1800)
    assert game.over
    again = hx.Replay.of(game)
    enemy = "blue" if side == "red" else "red"
    kinds = ("state", "event", "orders")
    assert [line for line in again.lines if line["type"] in kinds] == [
        line for line in replay.lines if line["type"] in kinds
    ]
    decided, known = (
        [line for line in one.lines if line["type"] == "decision" and line["camp"] == enemy]
        for one in (again, replay)
    )
    assert decided == known
    again.verify()


@pytest.mark.parametrize("opponent", ["MA1", "HRL0"])
def test_the_pace_changes_nothing(opponent: str) -> None:
    whole, slow = (Game("hills", seed=5, opponent=opponent, side="blue") for _ in range(2))
    for game in (whole, slow):
        game.submit("blue", "tank0 hide")
    whole.advance(1800)
    while not slow.over:
        slow.advance(7)
    assert told(whole) == told(slow)
    assert whole.recorder.lines == slow.recorder.lines


def test_a_copy_goes_on_by_itself() -> None:
    game = Game("plain", seed=1, opponent="MA1", side="blue")
    game.advance(200)
    other = game.copy()
    other.submit("blue", "tank0 hide")
    other.advance(1800)
    before = told(game)
    assert game.tick == 200
    third = game.copy()
    for each in (game, third):
        each.advance(1800)
    assert before != told(game) == told(third) != told(other)


def test_nobody_orders_for_a_camp_that_was_left() -> None:
    """Both camps of an arena left to hand, and a game by orders in which nobody gives any: the same."""
    arena = Arena(load_world("plain"), 1)
    arena.begin(0, 7, None, None)
    for camp in (Camp.RED, Camp.BLUE):
        arena.leave(0, camp)
    arena.advance(np.zeros(1, np.int64))
    alone = by_orders.Game("plain", seed=7)
    alone.advance(1800)
    assert arena.over(np.zeros(1, np.int64)).all()
    assert state_hash(arena.state, 0) == told(alone)


def test_without_an_opponent_both_camps_are_ordered() -> None:
    game = Game("plain", seed=0)
    assert game.submit("red", "tank0 hide") == game.submit("blue", "tank0 hide") == [None]
    with game.edit():
        pass
    game.copy().advance(3)


@pytest.mark.parametrize(
    ("what", "error", "said"),
    [
        ({"opponent": "nobody"}, UnknownNameError, "nobody"),
        ({"opponent": "MA1", "side": "green"}, UnknownNameError, "green"),
        ({"opponent": 3}, ConfigError, "a player is"),
    ],
)
def test_a_bad_seat_is_refused(what: dict[str, Any], error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        Game("plain", **what)


def test_the_opponents_camp_is_its_own() -> None:
    game = Game("plain", opponent="MA1", side="red")
    with pytest.raises(ConfigError, match="MA1 gives the orders of blue; expected orders for red"):
        game.submit("blue", "tank0 hide")
    with pytest.raises(ConfigError, match="cannot be edited"), game.edit():
        pass
