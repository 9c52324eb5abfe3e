"""How well a lower level leads: routes over an empty map, against the fastest ways (IV-D; learning.md, section 2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import cells_apart, frame_direction
from hexwar_sb3.maps.scenario import PieceStart, ScenarioLike
from hexwar_sb3.players.frozen_lower import FrozenLower, check_answers, make_lower
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

    @property
    def columns(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Kind, camp, cell, goal [n]."""
        return self.kind, self.camp, self.cell, self.goal

    def part(self, which: NDArray[Any]) -> Routes:
        """Some of the routes, by number or by a mask."""
        return Routes(*(value[which] for value in self.columns))


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
    lower: object, scenario: ScenarioLike = "plain", routes: int = 500, seed: int = 0
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
    all_routes = Routes(*(np.concatenate(values) for values in zip(*(r.columns for r in drawn), strict=True)))
    walk = _walk(world, all_routes, _leader(lower))
    kinds = [kind for kind in PieceType if (all_routes.kind == kind).any()]
    results = [walk.result(kind.name.lower(), all_routes.kind == kind) for kind in kinds]
    return [*results, walk.result("all", np.ones(all_routes.kind.size, np.bool_))]


def draw_routes(world: World, piece: PieceStart, count: int, rng: np.random.Generator) -> Routes:
    """Routes of one piece from its start to random cells that it can reach."""
    goals = rng.permutation(np.flatnonzero(world.cells.passable == 1))
    kind, camp, cell = (np.full(len(goals), int(value)) for value in (piece.kind, piece.camp, piece.cell))
    long = np.zeros(len(goals), np.bool_)
    find_long(kind, cell, goals, *LENGTHS, world.rules[0], world.cells, world.eta, long)
    return Routes(kind, camp, cell, goals).part(long & (long.cumsum() <= count))


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
    under_way = np.arange(n)
    while under_way.size:
        answers = lead(world, routes.part(under_way))
        go_on(
            under_way, answers, *routes.columns, world.rules[0], world.cells, world.eta,
            walk.ticks, walk.moves, walk.agreeing,
        )  # fmt: skip
        stayed = under_way[answers == STAY]
        walk.finished[stayed] = routes.cell[stayed] == routes.goal[stayed]
        in_time = walk.ticks[under_way] <= TIME_LIMIT * walk.fastest[under_way]
        under_way = under_way[(answers != STAY) & in_time]
    return walk


def _ways(world: World, routes: Routes) -> NDArray[np.int64]:
    ticks = np.zeros(routes.kind.size, np.int64)
    time_routes(routes.kind, routes.cell, routes.goal, world.rules[0], world.cells, world.eta, ticks)
    return ticks


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
    observe_routes(*routes.columns, ways, world.rules[0], world.cells, world.eta, states, masks)
    return states, masks


def _heuristic(world: World, routes: Routes) -> NDArray[np.int64]:
    answers = np.zeros(routes.kind.size, np.int64)
    follow_ways(*routes.columns, world.rules[0], world.cells, world.eta, answers)
    return answers


# Loops over routes: kind, camp, cell, goal [n] are those of `Routes`; the last arguments are written.


@kernel
def find_long(
    kind: Rows, cell: Rows, goal: Rows, least: int, most: int, rules: Row, cells: Rows, eta: Rows, out: Rows
) -> None:  # fmt: skip
    """Whether each goal can be reached and is so many cells away, as the crow flies: out [n]."""
    for k in range(kind.size):
        far = least <= cells_apart(cells, cell[k], goal[k]) <= most
        out[k] = far and has_way(kind[k], cell[k], goal[k], rules, cells, eta)


@kernel
def time_routes(kind: Rows, cell: Rows, goal: Rows, rules: Row, cells: Rows, eta: Rows, ticks: Rows) -> None:
    """Fastest time of each route: ticks [n]."""
    for k in range(kind.size):
        ticks[k] = travel_ticks(kind[k], cell[k], goal[k], rules, cells, eta)


@kernel
def observe_routes(
    kind: Rows, camp: Rows, cell: Rows, goal: Rows, ways: bool, rules: Row, cells: Rows, eta: Rows, states: Rows,
    masks: Rows,
) -> None:  # fmt: skip
    """What the lower level reads on each route: states f4 [n, Dl], masks i1 [n, 7]."""
    for k in range(kind.size):
        observe_route(
            kind[k], camp[k], TaskKind.HOLD, cell[k], goal[k], ways, rules, cells, eta, states[k], masks[k]
        )


@kernel
def follow_ways(
    kind: Rows, camp: Rows, cell: Rows, goal: Rows, rules: Row, cells: Rows, eta: Rows, answers: Rows
) -> None:
    """Answers of the heuristic [n]."""
    for k in range(kind.size):
        direction = next_direction(kind[k], camp[k], cell[k], goal[k], False, rules, cells, eta)
        answers[k] = STAY if cell[k] == goal[k] else 1 + frame_direction(direction, camp[k])


@kernel
def go_on(
    which: Rows, answers: Rows, kind: Rows, camp: Rows, cell: Rows, goal: Rows, rules: Row, cells: Rows, eta: Rows,
    ticks: Rows, moves: Rows, agreeing: Rows,
) -> None:  # fmt: skip
    """Let piece which[k] make the hop answers[k], if it is one: cell, ticks, moves, and those on a fastest way [n]."""
    for k in range(which.size):
        if answers[k] == STAY:
            continue
        i = which[k]
        direction = frame_direction(answers[k] - 1, camp[i])
        hop = hop_from(kind[i], cell[i], direction, rules, cells)
        there = cells[cell[i]].neighbour[direction]
        rest = travel_ticks(kind[i], there, goal[i], rules, cells, eta)
        agreeing[i] += hop + rest == travel_ticks(kind[i], cell[i], goal[i], rules, cells, eta)
        moves[i] += 1
        ticks[i] += hop
        cell[i] = there
