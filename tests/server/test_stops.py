"""What stops the clock: first sight, own losses, idle pieces; each can be switched off, and none comes twice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.view import LostEnemy, SideView
from hexwar_sb3.server.stops import FORGOTTEN_TICKS, Stops, Watcher

BOARD = """
    map   plain-40x9
    point ford 0604 40
    red   tank 0204
    blue  tank 3904
    ticks 900
"""


@pytest.fixture
def game() -> Game:
    return Game.from_text(BOARD)


def views(game: Game, ticks: int) -> Iterator[SideView]:
    for _ in range(ticks):
        game.advance(1)
        yield game.view("red")


def said(game: Game, ticks: int, stops: Stops, planned: tuple[str, ...] = ()) -> list[str]:
    watcher = Watcher(game.view("red"), planned)
    return [one for view in views(game, ticks) for one in watcher.look(view, planned, stops)]


def test_an_enemy_that_comes_into_sight_is_told_once(game: Game) -> None:
    game.submit("blue", "tank0 move " + "W " * 20)

    found = said(game, 400, Stops(own_loss=False, idle=False))

    assert found == ["blue:tank0 came into sight in 2704"]


@pytest.mark.parametrize(
    ("unseen_ticks", "counts"), [(1, False), (FORGOTTEN_TICKS, False), (FORGOTTEN_TICKS + 1, True)]
)
def test_an_enemy_that_was_away_for_long_is_news(game: Game, unseen_ticks: int, counts: bool) -> None:
    with game.edit() as state:
        state["blue:tank0"].cell = "1004"
    now = game.view("red")
    (enemy,) = now.seen
    lost = LostEnemy(name=enemy.name, kind="tank", cell="1104", blood=3, unseen_ticks=unseen_ticks)
    watcher = Watcher(replace(now, seen=(), lost=(lost,)), ())

    assert bool(watcher.look(now, (), Stops())) is counts


def test_own_losses_are_told(game: Game) -> None:
    before = game.view("red")
    with game.edit() as state:
        state["red:tank0"].blood = 1
    hurt = game.view("red")
    with game.edit() as state:
        state["red:tank0"].blood = 0
    dead, watcher = game.view("red"), Watcher(before, ())

    assert watcher.look(hurt, (), Stops()) == ["tank0 lost 2, 1 left"]
    assert watcher.look(dead, (), Stops()) == ["tank0 was destroyed"]
    assert watcher.look(dead, (), Stops()) == []


def test_a_piece_that_has_done_what_it_was_told_is_told(game: Game) -> None:
    game.submit("red", "tank0 move E")

    assert said(game, 200, Stops()) == ["tank0 has done what it was told, in 0304"]


def test_a_piece_with_a_plan_is_not_idle(game: Game) -> None:
    game.submit("red", "tank0 move E")

    assert said(game, 200, Stops(), ("tank0",)) == []


def test_an_order_that_is_done_at_once_makes_idle_too(game: Game) -> None:
    view = game.view("red")
    watcher = Watcher(view, ("tank0",))

    assert watcher.look(view, (), Stops()) == ["tank0 has done what it was told, in 0204"]


@pytest.mark.parametrize("name", ["first_sight", "own_loss", "idle"])
def test_each_can_be_switched_off(game: Game, name: str) -> None:
    before = game.view("red")
    with game.edit() as state:
        state["red:tank0"].blood = 1
        state["blue:tank0"].cell = "1004"
    watchers = [Watcher(before, ("tank0",)) for _ in range(2)]
    now = game.view("red")

    every, fewer = (
        watcher.look(now, (), stops)
        for watcher, stops in zip(watchers, (Stops(), replace(Stops(), **{name: False})), strict=True)
    )

    assert len(every) == 3
    assert len(fewer) == 2
