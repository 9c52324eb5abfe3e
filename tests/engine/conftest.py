"""Boards and random play that the tests of the engine share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hexwar_sb3.engine.state import State, new_state, reset_game
from hexwar_sb3.engine.step import advance, advance_by_ticks
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.maps.scenario import Scenario
from tests.engine.random_orders import random_orders

ARENA = """
    map     plain-13x9
    point   main 0705 80
    point   near 0507 30
    point   far 0907 30
    cell    0703 0707 concealed
    cell    0503 0903 0504 0804 elev 40
    cell    0604 0704 0605 0805 slushy
    cell    0306 1006 1105 0305 concealed elev 20
    cell    0105 0205 0305 0405 0505 0605 0705 0805 0905 1005 1105 1205 1305 paved
    cell    0602 0702 blocked
"""
SIDE = """
    red     tank 0104
    red     tank 0106
    red     chariot 0204
    red     chariot 0206
    red     soldier aboard chariot0
    red     soldier aboard chariot1
    red     aerocraft 0105
"""


@pytest.fixture(scope="session")
def small_world() -> World:
    """A small mirror-symmetric map with every kind of terrain and seven pieces a side, close together."""
    return load_world(small_scenario())


def small_scenario() -> Scenario:
    board = parse_board(ARENA)
    mirror = {}
    width, _ = board.map.width, board.map.height
    for name in ("0104", "0106", "0204", "0206", "0105"):
        x, y = int(name[:2]) - 1, int(name[2:]) - 1
        mirror[name] = board.map.cell_name(y * width + width - 1 - (y & 1) - x)
    blue = SIDE.replace("red ", "blue")
    for name, image in mirror.items():
        blue = blue.replace(f" {name}", f" {image}")
    scenario = parse_board(ARENA + SIDE + blue).scenario
    assert scenario.hexmap.is_symmetric()
    return scenario


Step = Callable[[State], None]
Play = Callable[..., State]


@pytest.fixture(scope="session")
def play_randomly() -> Play:
    """`play_randomly(world, seed, until, ...)`: a game of random legal orders, as a State of one game."""
    return play


def play(
    world: World,
    seed: int,
    until: int = 1800,
    *,
    by_ticks: bool = False,
    each: Step | None = None,
    every: int = 12,
) -> State:
    """Play random legal orders, given every 1 to `every` ticks, and look at each state that gets orders."""
    state = new_state(world, 1)
    reset_game(state, 0, world, seed)
    game, pieces, *_, orders, _ = state.game(0)
    rng = np.random.default_rng(seed)
    move = advance_by_ticks if by_ticks else advance
    while game.tick < until and not game.over:
        random_orders(np.uint64(seed), game, pieces, orders, *world.tables[:2])
        move(min(int(game.tick) + int(rng.integers(1, every + 1)), until), *state.game(0), *world.tables)
        if each is not None:
            each(state)
    return state
