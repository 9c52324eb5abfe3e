"""How well a lower level leads (IV-D): finished routes, agreement with the fastest ways, slowness."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.routes import LENGTHS, RouteResult, draw_routes, measure_routes
from hexwar_sb3.maps.geometry import W, cells_apart
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.players.frozen_lower import FORMAT, SIZES, FrozenLower, fastest_way_network
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.tasks.features import feature_index
from hexwar_sb3.tasks.route import STAY
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks

PLACES = feature_index("route", 1, 1, 1)
HERE = PLACES["goal: here"].start
DETOURS = [PLACES[f"neighbour {d}: detour"].start for d in range(6)]
TEN_CELLS = """
    map  plain-12x3
    red  tank 0202
"""  # the only cells at least 10 away are the last ones of rows 1 and 3, exactly 10 away

States = NDArray[np.float32]
Masks = NDArray[np.int8]


def nearest_way(states: States, masks: Masks) -> NDArray[np.int64]:
    detours = np.where(masks[:, 1:] != 0, states[:, DETOURS], np.inf)
    return np.where(states[:, HERE] == 1, STAY, 1 + detours.argmin(axis=1))


class Detour:
    """Goes `steps` times to the west first, then the fastest way."""

    def __init__(self, steps: int) -> None:
        self.steps = steps

    def __call__(self, states: States, masks: Masks) -> NDArray[np.int64]:
        self.steps -= 1
        return np.full(len(states), 1 + W) if self.steps >= 0 else nearest_way(states, masks)


class Circler:
    """Turns through all directions, and never stays."""

    def __init__(self) -> None:
        self.turn = 0

    def __call__(self, states: States, masks: Masks) -> NDArray[np.int64]:
        self.turn += 1
        order = (self.turn + np.arange(6)) % 6
        return 1 + order[masks[:, 1:][:, order].argmax(axis=1)]


@pytest.fixture(scope="module")
def lane() -> Scenario:
    return parse_board(TEN_CELLS).scenario


def last(results: list[RouteResult]) -> RouteResult:
    return results[-1]


@pytest.mark.parametrize("scenario", STANDARD)
@pytest.mark.parametrize("lower", ["heuristic", nearest_way])
def test_the_heuristic_finishes_all_routes_on_fastest_ways(scenario: str, lower: Any) -> None:
    """By its name, and as a callable that reads the state."""
    results = measure_routes(lower, scenario, routes=3)

    assert [one.piece for one in results] == ["tank", "chariot", "soldier", "aerocraft", "all"]
    assert [one.routes for one in results] == [12, 12, 12, 6, 42]
    assert all((one.finished, one.agreement, one.slowness) == (1.0, 1.0, 1.0) for one in results)


def test_who_walks_in_circles_finishes_none() -> None:
    result = last(measure_routes(Circler(), "plain", routes=2))
    assert result.finished == 0.0
    assert 0.0 < result.agreement < 0.7
    assert np.isnan(result.slowness)


def test_who_stays_elsewhere_is_refused(lane: Scenario) -> None:
    """Staying is valid in the right place alone; a network cannot choose it."""
    with pytest.raises(ConfigError, match=r"valid answers by the masks, got \[0\]"):
        measure_routes(lambda states, _: np.zeros(len(states), np.int64), lane, routes=1)

    weights = {name: np.zeros([SIZES[a] for a in axes], np.float32) for name, axes in FORMAT.layers.items()}
    weights["layer3.bias"][STAY] = 1.0
    assert last(measure_routes(FrozenLower(weights), lane, routes=1)).finished == 0.0


def test_moves_off_the_fastest_ways_and_their_time_are_counted(lane: Scenario) -> None:
    """One cell back and eleven forward: 11 moves of 12 agree, and 12 hops take the time of 10."""
    result = last(measure_routes(Detour(1), lane, routes=2))

    assert result.routes == 2
    assert result.finished == 1.0
    assert result.agreement == pytest.approx(11 / 12)
    assert result.slowness == pytest.approx(12 / 10)


def test_a_route_of_more_than_twice_the_fastest_time_is_not_finished() -> None:
    """Five cells back and 15 forward take just twice the time; six and 16 more."""
    text = TEN_CELLS.replace("plain-12x3", "plain-17x3").replace("0202", "0702")
    scenario = parse_board(text).scenario
    far = [draw_routes(load_world(scenario), piece, 9, np.random.default_rng(0)) for piece in scenario.pieces]
    assert {int(goal) % 17 for goal in far[0].goal} == {16}

    in_time, late = (last(measure_routes(Detour(steps), scenario, routes=2)) for steps in (5, 6))

    assert (in_time.finished, in_time.slowness) == (1.0, 2.0)
    assert late.finished == 0.0


def test_routes_lead_ten_to_forty_cells_to_where_the_type_can_go() -> None:
    world = load_world("hills")
    for piece in world.scenario.pieces:
        routes = draw_routes(world, piece, 20, np.random.default_rng(0))
        assert routes.goal.size == 20
        assert set(routes.kind) == {piece.kind}
        assert set(routes.camp) == {piece.camp}
        assert set(routes.cell) == {piece.cell}
        assert len(set(routes.goal.tolist())) == 20
        for goal in routes.goal.tolist():
            assert LENGTHS[0] <= cells_apart(world.cells, CellIndex(piece.cell), goal) <= LENGTHS[1]
            assert (
                travel_ticks(piece.kind, CellIndex(piece.cell), goal, world.rules[0], world.cells, world.eta)
                < UNREACHABLE
            )


def test_the_seed_decides_which_routes() -> None:
    results = [measure_routes(Circler(), "plain", routes=2, seed=seed) for seed in (0, 0, 1)]
    agreements = [[one.agreement for one in result] for result in results]
    assert agreements[0] == agreements[1] != agreements[2]


def test_a_network_without_ways_reads_none() -> None:
    """One that looks at detours alone finds its way with them, and is lost without."""
    network = fastest_way_network()
    blind = FrozenLower(network.weights, ways=False)

    knowing, lost = (last(measure_routes(lower, "plain", routes=2)) for lower in (network, blind))

    assert (knowing.finished, knowing.agreement, knowing.slowness) == (1.0, 1.0, 1.0)
    assert lost.finished < 0.5


def test_blue_is_led_in_its_own_frame() -> None:
    """East for red is west for blue: both come to the far side."""
    text = "map plain-12x3\nblue tank 1002\n"
    result = last(measure_routes(Detour(0), parse_board(text).scenario, routes=2))
    assert (result.finished, result.agreement) == (1.0, 1.0)
    back = last(measure_routes(Detour(1), parse_board(text).scenario, routes=2))
    assert back.agreement == pytest.approx(11 / 12)


def test_a_summary_is_plain_values() -> None:
    summary = last(measure_routes("heuristic", "plain", routes=1)).summary()
    assert summary == {"piece": "all", "routes": 14, "finished": 1.0, "agreement": 1.0, "slowness": 1.0}


@pytest.mark.parametrize("routes", [0, -1])
def test_no_routes_are_refused(routes: int) -> None:
    with pytest.raises(ConfigError, match=f"routes must be at least 1, got {routes}"):
        measure_routes("heuristic", "plain", routes=routes)


def test_types_keep_the_order_of_the_rules(lane: Scenario) -> None:
    assert [one.piece for one in measure_routes("heuristic", lane, routes=1)] == ["tank", "all"]
    assert lane.pieces[0].camp == Camp.RED
    assert lane.pieces[0].kind == PieceType.TANK
