"""How well a lower level leads: routes over an empty map, against the fastest ways (IV-D; learning.md, section 2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.geometry import cells_apart, frame_direction
from hexwar_sb3.maps.scenario import PieceStart, Scenario
from hexwar_sb3.play.lower_policy import FrozenLower, check_answers, make_lower
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.route import STAY, has_way, new_route_buffers, observe_route
from hexwar_sb3.tasks.travel import next_direction, travel_ticks

LENGTHS = (10, 40)  # cells from start to goal, as the crow flies
TIME_LIMIT = 2  # times the fastest time

Leader = Callable[[World, "Routes"], NDArray[np.int64]]


@dataclass
class Routes:
    """Pieces on their way, a row a route."""

    kind: NDArray[np.int64]
    camp: NDArray[np.int64]
    cell: NDArray[np.int64]
    goal: NDArray[np.int64]

    def part(self, which: NDArray[np.bool_]) -> Routes:
        """Some of the routes."""
        return Routes(*(value[which] for value in vars(self).values()))


@dataclass(frozen=True)
class RouteResult:
    """Routes of one type of piece."""

    piece: str
    routes: int
    finished: float  # share that stays in the goal within twice the fastest time
    agreement: float  # share of the moves that lie on any fastest way
    slowness: float  # mean time over the fastest, of the finished ones

    def summary(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def measure_routes(
    lower: object, scenario: str | Path | Scenario = "plain", routes: int = 500, seed: int = 0
) -> list[RouteResult]:
    """Lead pieces from their starts to cells 10 to 40 cells away, no enemy about; a result a type, and "all".

    Args:
        lower: "heuristic", a folder, a network or a callable, as `make_lower` takes them.
        scenario: name, file or object.
        routes: of each piece of the scenario.
        seed: of the goals.

    Raises:
        ConfigError: no route is asked for.
    """
    if routes < 1:
        raise ConfigError(f"routes must be at least 1, got {routes}")
    world = load_world(scenario)
    rng = np.random.default_rng(seed)
    drawn = [draw_routes(world, piece, routes, rng) for piece in world.scenario.pieces]
    all_routes = Routes(
        *(np.concatenate(values) for values in zip(*(vars(r).values() for r in drawn), strict=True))
    )
    walk = _walk(world, all_routes, _leader(lower))
    kinds = [kind for kind in PieceType if (all_routes.kind == kind).any()]
    results = [walk.result(kind.name.lower(), all_routes.kind == kind) for kind in kinds]
    return [*results, walk.result("all", np.ones(all_routes.kind.size, np.bool_))]


def draw_routes(world: World, piece: PieceStart, count: int, rng: np.random.Generator) -> Routes:
    """Routes of one piece from its start to random cells that it can reach."""
    cells, goals = world.cells, []
    for goal in rng.permutation(np.flatnonzero(cells.passable == 1)).tolist():
        far = LENGTHS[0] <= cells_apart(cells, piece.cell, goal) <= LENGTHS[1]
        if far and has_way(piece.kind, piece.cell, goal, world.rules[0], cells, world.eta):
            goals.append(goal)
        if len(goals) == count:
            break
    n = len(goals)
    camps, kinds = np.full(n, int(piece.camp)), np.full(n, int(piece.kind))
    return Routes(kinds, camps, np.full(n, piece.cell), np.array(goals, np.int64))


@dataclass
class _Walk:
    """What became of every route."""

    fastest: NDArray[np.int64]  # ticks
    ticks: NDArray[np.int64]
    finished: NDArray[np.bool_]
    moves: NDArray[np.int64]
    agreeing: NDArray[np.int64]

    def result(self, piece: str, which: NDArray[np.bool_]) -> RouteResult:
        """Count some of the routes."""
        done = which & self.finished
        return RouteResult(
            piece,
            int(which.sum()),
            float(self.finished[which].mean()),
            float(self.agreeing[which].sum() / max(1, self.moves[which].sum())),
            float((self.ticks[done] / self.fastest[done]).mean()) if done.any() else float("nan"),
        )


def _walk(world: World, routes: Routes, lead: Leader) -> _Walk:
    """Lead every piece until it stays, or its time is over."""
    n = routes.kind.size
    walk = _Walk(
        _ways(world, routes), np.zeros(n, np.int64), np.zeros(n, np.bool_), *np.zeros((2, n), np.int64)
    )
    under_way = np.ones(n, np.bool_)
    while under_way.any():
        rows = np.flatnonzero(under_way)
        for row, answer in zip(rows, lead(world, routes.part(under_way)), strict=True):
            if answer == STAY:
                walk.finished[row] = routes.cell[row] == routes.goal[row]
                under_way[row] = False
            else:
                _hop(world, routes, walk, int(row), int(answer))
                under_way[row] = walk.ticks[row] <= TIME_LIMIT * walk.fastest[row]
    return walk


def _hop(world: World, routes: Routes, walk: _Walk, row: int, answer: int) -> None:
    kind, here, goal = int(routes.kind[row]), int(routes.cell[row]), int(routes.goal[row])
    direction = frame_direction(answer - 1, int(routes.camp[row]))
    tables = world.rules[0], world.cells
    hop = hop_from(kind, here, direction, *tables)
    there = int(world.cells[here].neighbour[direction])
    rest = travel_ticks(kind, there, goal, *tables, world.eta)
    walk.agreeing[row] += hop + rest == travel_ticks(kind, here, goal, *tables, world.eta)
    walk.moves[row] += 1
    walk.ticks[row] += hop
    routes.cell[row] = there


def _ways(world: World, routes: Routes) -> NDArray[np.int64]:
    pairs = zip(routes.kind.tolist(), routes.cell.tolist(), routes.goal.tolist(), strict=True)
    return np.array([travel_ticks(*pair, world.rules[0], world.cells, world.eta) for pair in pairs], np.int64)


def _leader(lower: object) -> Leader:
    """Who answers, as a function of the routes."""
    made = make_lower(lower)
    if isinstance(made, str):
        return _heuristic
    ways = made.ways if isinstance(made, FrozenLower) else True

    def lead(world: World, routes: Routes) -> NDArray[np.int64]:
        states, masks = _observe(world, routes, ways)
        return check_answers(made(states, masks), masks)

    return lead


def _observe(world: World, routes: Routes, ways: bool) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
    states, masks = new_route_buffers(routes.kind.size)
    for k in range(routes.kind.size):
        observe_route(
            routes.kind[k], routes.camp[k], TaskKind.HOLD, routes.cell[k], routes.goal[k], ways,
            world.rules[0], world.cells, world.eta, states[k], masks[k],
        )  # fmt: skip
    return states, masks


def _heuristic(world: World, routes: Routes) -> NDArray[np.int64]:
    answers = np.zeros(routes.kind.size, np.int64)
    for k in range(routes.kind.size):
        direction = next_direction(
            routes.kind[k], routes.camp[k], routes.cell[k], routes.goal[k], False,
            world.rules[0], world.cells, world.eta,
        )  # fmt: skip
        if routes.cell[k] != routes.goal[k]:
            answers[k] = 1 + frame_direction(direction, int(routes.camp[k]))
    return answers
