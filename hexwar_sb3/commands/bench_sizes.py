"""What larger wars cost: pieces, cells and games against process time and memory."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import partial
from itertools import pairwise, product
from math import log
from time import process_time
from typing import Any

from hexwar_sb3.commands.bench_games import best
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.maps.generator import generate, standard_scenario
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.spec import MAP_SPECS
from hexwar_sb3.maps.travel import asked
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.terms import Terms

PIECES = (7, 15, 30, 60)  # a side
MAPS = ((32, 32), (71, 70), (142, 140), (245, 245))  # about 1,000, 5,000, 20,000 and 60,000 cells
HEADS = {
    "pieces": "a side",
    "cells": "cells",
    "table_s": "tables, s",
    "table_mb": "tables, MB",
    "ways_mb": "ways asked for, MB",
    "game_kb": "a game, KB",
    "random_ms": "random players, ms a game",
    "bots_ms": "MA1 against MA2, ms a game",
}
TIMES = {"random_ms": "random players", "bots_ms": "MA1 against MA2"}
MB, KB = 1e6, 1e3
LEAST_GAMES, PIECE_GAMES = 2, 120  # of a round: fewer where they are larger


def size_figures(rounds: int) -> list[dict[str, float]]:
    """Measure every number of pieces on the usual map, and seven and sixty a side on all maps."""
    found = []
    for pieces, size in product(PIECES, MAPS):
        if size == MAPS[1] or pieces in (PIECES[0], PIECES[-1]):
            found.append(_row(war(pieces, size), pieces, rounds))
    return found


def war(pieces: int, size: tuple[int, int]) -> Scenario:
    """So many pieces a side on a map like "plain" of some width and height."""
    spec = MAP_SPECS["plain"].resized(*size)
    return standard_scenario(generate(spec), replace(spec.start, pieces=(pieces, pieces)))


def exponents(rows: list[dict[str, float]]) -> dict[str, list[float]]:
    """By which power the time of a game grows, from row to row: with pieces on the usual map, with cells for each number."""
    usual = sorted({row["cells"] for row in rows})[1]
    groups = {"with pieces": ("pieces", [row for row in rows if row["cells"] == usual])}
    for count in (PIECES[0], PIECES[-1]):
        groups[f"with cells, {count} a side"] = "cells", [row for row in rows if row["pieces"] == count]
    return {
        f"{TIMES[of]} {name}": [log(b[of] / a[of]) / log(b[by] / a[by]) for a, b in pairwise(part)]
        for of, (name, (by, part)) in product(TIMES, groups.items())
    }


def _row(scenario: Scenario, pieces: int, rounds: int) -> dict[str, float]:
    start = process_time()
    world = load_world(scenario)
    tables = world.los.nbytes + world.cells.nbytes
    built = process_time() - start
    games = max(LEAST_GAMES, PIECE_GAMES // pieces)
    times = {
        name: best(partial(_games, pair, games, scenario), rounds)
        for name, pair in {"random_ms": ("random", "random"), "bots_ms": ("MA1", "MA2")}.items()
    }
    return {
        "pieces": pieces,
        "cells": int(world.cells.playable.sum()),
        "table_s": built,
        "table_mb": tables / MB,
        "ways_mb": _ways_bytes(world) / MB,
        "game_kb": _game_bytes(world) / KB,
        **{name: KB / rate for name, rate in times.items()},
    }


def _games(pair: tuple[str, str], games: int, scenario: Scenario, seed: int) -> tuple[float, float]:
    start = process_time()
    play_games(*pair, games, Terms(scenario=scenario), seed)
    return float(games), process_time() - start


def _ways_bytes(world: World) -> int:
    """Bytes of the rows of travel times that were asked for so far."""
    return asked(world.eta) * int(world.eta.shape[1])


def _game_bytes(world: World) -> int:
    """What one game more takes in a batch."""
    arena = Arena(world, 1, Terms())
    state: list[Any] = [getattr(arena.state, field.name) for field in fields(arena.state)]
    return sum(int(array.nbytes) for array in (*state, arena.missions, arena.brains, arena.drives))
