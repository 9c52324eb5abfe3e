"""Properties over whole games of random legal orders (rule book, section 14; architecture.md, section 2)."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.batch import Engine
from hexwar_sb3.engine.pieces import is_ground
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE, ROUND_FREE
from hexwar_sb3.engine.sight import look_all
from hexwar_sb3.engine.state import State, new_state, reset_game
from hexwar_sb3.engine.step import advance
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.geometry import MIRROR_DIRECTION
from hexwar_sb3.rules.enums import Camp
from tests.engine.random_orders import random_orders

Play = Callable[..., State]

FEW = range(12)
MANY = [range(first, first + 100) for first in range(0, 1000, 100)]
SEEDS = [
    pytest.param(FEW, id="few"),
    *(pytest.param(seeds, id=f"from-{seeds.start}", marks=pytest.mark.slow) for seeds in MANY),
]


def same(a: State, b: State) -> bool:
    """Every field of every record, and the paths as far as they are still to be walked."""
    pairs = [(a.games, b.games), (a.pieces, b.pieces), (a.memory, b.memory), (a.rounds, b.rounds)]
    equal = all((x[name] == y[name]).all() for x, y in pairs for name in x.dtype.names or ())
    ways = [[p.tolist() for p in unwalked(state)] for state in (a, b)]
    return equal and ways[0] == ways[1]


def unwalked(state: State) -> list[Rows]:
    pairs = zip(state.pieces[0], state.paths[0], strict=True)
    return [path[piece.path_pos : piece.path_len] for piece, path in pairs]


@pytest.mark.parametrize("seeds", SEEDS)
def test_jumping_from_event_to_event_gives_the_same_game_as_every_tick(
    small_world: World, play_randomly: Play, seeds: Iterable[int]
) -> None:
    """Steps in which nothing is due change nothing but the clock (architecture.md, section 2)."""
    for seed in seeds:
        jumped = play_randomly(small_world, seed)
        assert same(jumped, play_randomly(small_world, seed, by_ticks=True)), seed


@pytest.mark.parametrize("seeds", SEEDS)
def test_incremental_sight_is_full_sight(
    small_world: World, play_randomly: Play, seeds: Iterable[int]
) -> None:
    """Only rows and columns of changed pieces are renewed; all pairs give the same (section 6)."""

    def compare(state: State) -> None:
        pieces = state.pieces[0].copy()
        look_all(pieces, *small_world.tables)
        assert (pieces.sees == state.pieces[0].sees).all()

    for seed in seeds:
        play_randomly(small_world, seed, each=compare)


@pytest.mark.parametrize("seeds", SEEDS)
def test_every_state_keeps_the_invariants_of_the_rules(
    small_world: World, play_randomly: Play, seeds: Iterable[int]
) -> None:
    """Sections 2, 3, 5, 13: blood, stacking, passengers, timers and control points stay possible."""

    def check(state: State) -> None:
        if state.games[0].tick % 4 == 0:
            check_invariants(state, small_world)

    for seed in seeds:
        play_randomly(small_world, seed, each=check)


def check_invariants(state: State, world: World) -> None:
    game, pieces, memory, _, rounds, *_ = state.game(0)
    rules, cells, _ = world.tables
    on_map = [p for p in pieces if p.blood > 0 and p.carrier == NO_PIECE]
    ground = [p for p in on_map if is_ground(p)]
    places = [(int(p.camp), int(p.cell)) for p in ground]
    assert all(places.count(place) <= rules.stack_limit for place in places)
    assert all(cells[p.cell].passable for p in ground)
    assert all(cells[p.cell].playable for p in pieces)
    assert all(0 <= p.blood <= rules.blood[p.kind] for p in pieces)
    for timer in ("arrives_at", "stop_ends", "hide_ends", "board_ends", "cool_ends", "keep_ends"):
        assert ((pieces[timer] == NEVER) | (pieces[timer] > game.tick)).all(), timer
    assert ((pieces.keep_ends != NEVER) == (pieces.suppressed == 1)).all()
    for i, p in enumerate(pieces):
        assert p.carrier == NO_PIECE or pieces[p.carrier].passenger == i
        assert p.carrier == NO_PIECE or pieces[p.carrier].cell == p.cell
        assert p.passenger == NO_PIECE or pieces[p.passenger].carrier == i
        assert p.board_partner == NO_PIECE or pieces[p.board_partner].board_partner == i
        assert not any((p.losses_now, p.hit_now, p.zero_now, *p.spent_now))
        assert not any((p.came_now, p.covered_now, p.changed_now))
    both = {cell for camp, cell in places if camp == 0} & {cell for camp, cell in places if camp == 1}
    assert sorted(c for c in game.fight_cell if c != NO_CELL) == sorted(both)
    for camp in (Camp.RED, Camp.BLUE):
        seen = np.bitwise_or.reduce(pieces.sees[pieces.camp == camp])
        now = [bool(int(seen) >> int(piece.slot) & 1) for piece in pieces]
        enemies = pieces.camp != camp
        assert (memory[camp].seen[enemies] == np.array(now)[enemies]).all()
        assert (memory[camp].cell[(memory[camp].seen == 1)] == pieces.cell[memory[camp].seen == 1]).all()
    assert all(r.status == ROUND_FREE or game.tick < r.end_at for r in rounds)


@pytest.mark.parametrize("seeds", SEEDS)
def test_a_game_in_a_batch_is_the_same_game_as_alone(
    small_world: World, play_randomly: Play, seeds: Iterable[int]
) -> None:
    """Dice are keyed by seed, never by slot (architecture.md, section 2)."""
    seeds = list(seeds)
    engine = Engine(small_world.scenario, n_games=len(seeds))
    engine.reset(seeds)
    state, stops = engine.state, {seed: order_ticks(seed) for seed in seeds}
    for tick in range(1, 1801):
        for b, seed in enumerate(seeds):
            if tick - 1 in stops[seed]:
                rows = state.games[b], state.pieces[b], state.orders[b]
                random_orders(np.uint64(seed), *rows, *small_world.tables[:2])
        engine.advance(1)
    for b, seed in enumerate(seeds):
        alone = play_randomly(small_world, seed)
        assert same(engine.snapshot(b), alone), seed


def order_ticks(seed: int, every: int = 12) -> set[int]:
    """The ticks at which `play_randomly` gives orders."""
    rng, tick, ticks = np.random.default_rng(seed), 0, set()
    while tick < 1800:
        ticks.add(tick)
        tick += int(rng.integers(1, every + 1))
    return ticks


# --- the mirror ----------------------------------------------------------------------------------

PLACES = {"cell", "next_cell", "impact", "fight_cell", "point_cell"}
LINKS = {"board_partner", "home", "carrier", "passenger", "owner", "target", "partner"}


def turned(state: State, world: World) -> State:
    """The mirror image of a game: west and east, the colours and the dice salts exchanged."""
    n = world.side(Camp.RED).stop
    image = new_state(world, 1)
    swap = np.r_[n : 2 * n, 0:n]
    owners = np.array([int(swap[owner]) for owner in state.rounds[0].owner])  # rounds are kept by owner
    image.games[0] = turned_rows(state.games[:1], world)[0]
    image.games[0].salt[:] = state.games[0].salt[::-1]
    for k in range(int(state.games[0].n_points)):
        owner = int(state.games[0].point_owner[k])
        image.games[0].point_owner[k] = {0: 1, 1: 0}.get(owner, owner)
    image.games[0].loss_tick[:] = state.games[0].loss_tick[::-1]
    image.games[0].contact_tick[:] = state.games[0].contact_tick[::-1]
    image.pieces[0] = turned_rows(state.pieces[0], world)[swap]
    image.memory[0] = turned_rows(state.memory[0], world)[::-1][:, swap]
    image.paths[0] = np.array(MIRROR_DIRECTION, np.uint8)[state.paths[0][swap]]
    rounds = turned_rows(state.rounds[0], world)
    image.rounds[0] = rounds[np.argsort(owners, kind="stable")]
    return image


def turned_orders(orders: Rows, world: World) -> Rows:
    n = world.side(Camp.RED).stop
    return np.roll(turned_rows(orders, world), n)


def turned_rows(rows: Rows, world: World) -> Rows:
    """Records with cells, piece numbers, camps and directions turned, in their old places."""
    n = world.side(Camp.RED).stop
    rows = rows.copy()
    for name in rows.dtype.names or ():
        values = rows[name]
        if name in PLACES:
            rows[name] = np.where(values < 0, values, world.cells.mirror[values])
        elif name in LINKS:
            rows[name] = np.where(values < 0, values, (values + n) % (2 * n))
        elif name == "camp":
            rows[name] = 1 - values
        elif name == "path":
            rows[name] = np.array(MIRROR_DIRECTION)[values]
        elif name == "judged":
            rows[name] = values[..., ::-1]
    return rows


def facts(state: State) -> list[Any]:
    """Everything but what has no order of its own or does not matter any more."""
    game, pieces, memory, _, rounds, *_ = state.game(0)
    fights = sorted((int(c), int(t)) for c, t in zip(game.fight_cell, game.fight_next, strict=True) if c >= 0)
    clocks = [
        game[name].tolist() for name in ("tick", "over", "point_owner", "loss_tick", "contact_tick", "salt")
    ]
    ways = [path.tolist() for path in unwalked(state)]
    flying = rounds[rounds.status != ROUND_FREE]
    return [clocks, fights, ways, *map(columns, (pieces, memory, flying))]


def columns(rows: Rows) -> dict[str, Any]:
    return {name: rows[name].tolist() for name in rows.dtype.names or ()}


def assert_turned(seed: int, world: World, until: int, every: int = 12) -> None:
    """Play a game and its mirror image side by side."""
    state = new_state(world, 1)
    reset_game(state, 0, world, seed)
    image = turned(state, world)
    rng = np.random.default_rng(seed)
    game, pieces, *_, orders, _ = state.game(0)
    while game.tick < until:
        random_orders(np.uint64(seed), game, pieces, orders, *world.tables[:2])
        image.orders[0] = turned_orders(orders, world)
        stop = min(int(game.tick) + int(rng.integers(1, every + 1)), until)
        advance(stop, *state.game(0), *world.tables)
        advance(stop, *image.game(0), *world.tables)
        if stop % 20 == 0 or stop == until:
            for a, b in zip(facts(turned(state, world)), facts(image), strict=True):
                assert a == b, (seed, stop)


@pytest.mark.parametrize("seeds", SEEDS)
def test_mirrored_orders_with_colours_and_dice_exchanged_give_the_mirrored_game(
    small_world: World, seeds: Iterable[int]
) -> None:
    """Neither colour has an advantage (rule book, sections 1, 11 and 14)."""
    for seed in seeds:
        assert_turned(seed, small_world, until=1800)


@pytest.mark.parametrize("name", ["plain", "hills", "paddy"])
def test_the_built_in_scenarios_are_fair_to_both_colours(name: str) -> None:
    """Mirrored game = game on each built-in map (section 14)."""
    assert_turned(3, load_world(name), until=600, every=75)


# --- plain Python --------------------------------------------------------------------------------

ROOT = Path(__file__).parents[2]  # where `tests` is found
SCRIPT = """
import numpy as np
np.seterr(over="ignore")
from tests.engine.random_orders import random_orders
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.state import new_state, reset_game
from hexwar_sb3.engine.step import advance
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import load_world

world = load_world(parse_board(open({board!r}).read()).scenario)
state = new_state(world, 1)
reset_game(state, 0, world, 5)
game, pieces, *_, orders, _ = state.game(0)
for stop in range(5, {until}, 5):
    random_orders(np.uint64(5), game, pieces, orders, *world.tables[:2])
    advance(stop, *state.game(0), *world.tables)
print(state_hash(state, 0), int(pieces.blood.sum()))
"""
PLAIN_BOARD = """
    map     plain-7x5
    point   main 0403 80
    cell    0402 concealed
    cell    0404 elev 20
    red     tank 0103
    red     chariot 0202
    red     soldier 0203
    red     aerocraft 0302
    blue    tank 0703
    blue    chariot 0602
    blue    soldier 0603
    blue    aerocraft 0502
"""


def test_compiled_kernels_and_plain_python_play_the_same_game(tmp_path: Path) -> None:
    """Every kernel runs uncompiled too (architecture.md, section 2)."""
    board = tmp_path / "board.txt"
    board.write_text(PLAIN_BOARD)
    script = SCRIPT.format(board=str(board), until=300)
    results = []
    for disabled in ("0", "1"):
        env = os.environ | {"NUMBA_DISABLE_JIT": disabled}
        run = subprocess.run(
            [sys.executable, "-c", script], env=env, cwd=ROOT, capture_output=True, text=True, check=True
        )
        results.append(run.stdout)
    assert results[0] == results[1]
    assert int(results[0].split()[1]) < 20, "nobody was hurt: the game proves little"
