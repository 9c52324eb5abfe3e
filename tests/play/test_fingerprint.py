"""A camp acts only on what is new to it."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.fingerprint import fingerprint
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Camp

RED_TANK, BLUE_TANK = 0, 7


@pytest.fixture(scope="module")
def arena() -> Arena:
    """A game in which the camps have met."""
    arena = Arena(load_world("plain"), 1, Terms(decision_ticks=900))
    arena.begin(0, 0, make_player("nearest"), make_player("nearest"))
    arena.drives.asked[:] = 1
    arena.advance(np.zeros(1, np.int64))
    return arena


def red_knows(state: Any) -> int:
    return fingerprint(Camp.RED, state.games[0], state.pieces[0], state.memory[0], state.rounds[0])


def copy_of(arena: Arena) -> Any:
    snapshot = arena.snapshot()
    return SimpleNamespace(**{name: array.view(np.recarray) for name, array in snapshot.items()})


def flip(name: str, array: str, place: tuple[int, ...]) -> Callable[[Any], None]:
    def change(state: Any) -> None:
        row = getattr(state, array)[place]
        row[name] = row[name] ^ 1

    return change


@pytest.mark.parametrize(
    "field", ["cell", "arrives_at", "cool_ends", "blood", "hidden", "suppressed", "sees", "path_pos"]
)
def test_a_change_of_an_own_piece_is_news(arena: Arena, field: str) -> None:
    state = copy_of(arena)
    flip(field, "pieces", (0, RED_TANK))(state)
    assert red_knows(state) != red_knows(copy_of(arena))


@pytest.mark.parametrize("field", ["cell", "blood", "seen", "moving", "next_cell"])
def test_a_change_of_what_is_seen_is_news(arena: Arena, field: str) -> None:
    state = copy_of(arena)
    flip(field, "memory", (0, Camp.RED, BLUE_TANK))(state)
    assert red_knows(state) != red_knows(copy_of(arena))


@pytest.mark.parametrize("field", ["cell", "arrives_at", "cool_ends", "blood", "hidden"])
def test_a_change_of_an_enemy_alone_is_none(arena: Arena, field: str) -> None:
    """What the camp knows is its memory; the enemy's record itself never counts."""
    state = copy_of(arena)
    flip(field, "pieces", (0, BLUE_TANK))(state)
    assert red_knows(state) == red_knows(copy_of(arena))


def test_time_alone_is_none(arena: Arena) -> None:
    state = copy_of(arena)
    state.games[0].tick += 1
    state.memory[0, Camp.RED, BLUE_TANK].tick += 1
    assert red_knows(state) == red_knows(copy_of(arena))


def test_a_taken_point_is_news(arena: Arena) -> None:
    state = copy_of(arena)
    state.games[0].point_owner[0] += 1
    assert red_knows(state) != red_knows(copy_of(arena))
