"""The lower level in the drive loop: networks, callables and kept directions ask and answer the same question."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.envs.route_vec_env import route_spaces
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.geometry import SE, E, W
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.lower import HEURISTIC, KEPT, asks
from hexwar_sb3.play.seeds import game_seed
from hexwar_sb3.players.frozen_lower import FORMAT, SIZES, FrozenLower, Lower, fastest_way_network
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.policies.masked import MaskedDQNPolicy, freeze_lower
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.features import ROUTE_WIDTH, feature_index
from hexwar_sb3.tasks.records import ENDED, STAYING, TaskKind
from hexwar_sb3.tasks.route import N_ANSWERS, STAY

PLACES = feature_index("route", 1, 1, 1)
HERE = PLACES["goal: here"].start
DETOURS = [PLACES[f"neighbour {d}: detour"].start for d in range(6)]
WAYS = [PLACES["goal: way"].start, *DETOURS]
PLAYED = ("games", "pieces", "memory", "paths", "rounds", "missions", "brains")
GAMES = 2

States = NDArray[np.float32]
Masks = NDArray[np.int8]


@pytest.fixture(scope="module")
def world() -> World:
    return load_world("plain")


def random_lower(seed: int, *, ways: bool = True) -> FrozenLower:
    """A network whose values differ."""
    rng = np.random.default_rng(seed)
    weights = {
        name: rng.normal(size=[SIZES[axis] for axis in axes]).astype(np.float32) / np.sqrt(SIZES[axes[-1]])
        for name, axes in FORMAT.layers.items()
    }
    return FrozenLower(weights, ways=ways)


def random_states(n: int) -> States:
    return np.random.default_rng(1).normal(size=(n, ROUTE_WIDTH)).astype(np.float32)


def nearest_way(states: States, masks: Masks) -> NDArray[np.int64]:
    """The heuristic as a callable: the smallest detour, the first of equals; stay in the right place."""
    detours = np.where(masks[:, 1:] != 0, states[:, DETOURS], np.inf)
    return np.where(states[:, HERE] == 1, STAY, 1 + detours.argmin(axis=1))


class Picker:
    """Player: valid tasks that change every six decisions, by what it observes alone."""

    def __init__(self, lower: Lower = "heuristic") -> None:
        self.lower = lower

    def reset(self) -> None: ...

    def act(self, obs: Any) -> NDArray[np.int64]:
        mask = obs["action_mask"]
        time_left = obs["obs"][:, 0, feature_index("obs", 7, 7, 2)["game: time left"].start]
        phase = np.round(time_left * 1800 / 450).astype(np.int64)[:, None]
        return (5 * phase + 3 * np.arange(mask.shape[1]) + 2) % mask.sum(axis=-1)


def seated(world: World, red: object, blue: object, terms: Terms | None = None) -> Arena:
    arena = Arena(world, GAMES, terms or Terms())
    for b in range(GAMES):
        arena.begin(b, game_seed(7, b), make_player(red), make_player(blue))
    return arena


def played_out(arena: Arena) -> dict[str, NDArray[Any]]:
    """Everything that changes in the games themselves, at their end."""
    which = np.arange(arena.n_games)
    while which.size:
        arena.ask(which.tolist())
        arena.advance(which)
        which = which[~arena.over(which)]
    return {name: array for name, array in arena.snapshot().items() if name in PLAYED}


def same(one: dict[str, NDArray[Any]], other: dict[str, NDArray[Any]]) -> bool:
    assert one.keys() == other.keys()
    return all(np.array_equal(one[name], other[name]) for name in one)


def by_colour(world: World, lower: Lower, camp: Camp) -> dict[str, NDArray[Any]]:
    """Games in which one camp is led by a lower level, the other one is a bot."""
    sides: list[object] = ["nearest", "nearest"]
    sides[camp] = Picker(lower)
    return played_out(seated(world, sides[0], sides[1]))


def test_values_of_the_answers_equal_those_of_torch() -> None:
    """Two layers of 64 with ReLU between (III-C), on 1,000 states."""
    lower, states = random_lower(0), random_states(1000)
    layers = [torch.nn.Linear(n, m) for n, m in ((ROUTE_WIDTH, 64), (64, 64), (64, N_ANSWERS))]
    for k, layer in enumerate(layers, 1):
        layer.load_state_dict(
            {name: torch.tensor(lower.weights[f"layer{k}.{name}"]) for name in ("weight", "bias")}
        )
    net = torch.nn.Sequential(layers[0], torch.nn.ReLU(), layers[1], torch.nn.ReLU(), layers[2])

    with torch.no_grad():
        expected = net(torch.tensor(states)).numpy()

    assert np.ptp(expected, axis=0).min() > 0.1
    np.testing.assert_allclose(lower.q_values(states), expected, atol=1e-5)


def test_an_exported_dqn_has_the_values_of_its_network() -> None:
    model = MaskedDQN.for_spaces(*route_spaces(), buffer_size=10, seed=0)
    states = random_states(1000)
    masks = torch.ones(1000, N_ANSWERS, dtype=torch.int8)

    with torch.no_grad():
        expected = model.policy.q_net({"obs": torch.tensor(states), "action_mask": masks}).numpy()

    lower = freeze_lower(cast("MaskedDQNPolicy", model.policy), ways=True)
    np.testing.assert_allclose(lower.q_values(states), expected, atol=1e-5)


def test_the_best_valid_answer_is_given_the_first_of_equals() -> None:
    weights = {name: np.zeros_like(value) for name, value in random_lower(0).weights.items()}
    weights["layer3.bias"] = np.array([9, 1, 5, 5, 0, -1, 2], np.float32)
    masks = np.array([[1] * 7, [0, 1, 1, 1, 1, 1, 1], [0, 0, 0, 0, 1, 1, 0], [0, 1, 0, 0, 0, 1, 0]], np.int8)

    assert FrozenLower(weights)(random_states(4), masks).tolist() == [0, 2, 4, 1]


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_a_callable_that_answers_like_the_heuristic_plays_its_games(world: World, camp: Camp) -> None:
    """Bit for bit: the loop stops to ask it, and nothing else changes."""
    asked: list[int] = []

    def lower(states: States, masks: Masks) -> NDArray[np.int64]:
        asked.append(len(states))
        return nearest_way(states, masks)

    assert same(by_colour(world, lower, camp), by_colour(world, "heuristic", camp))
    assert sum(asked) > 200


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_a_network_of_the_smallest_detour_plays_the_games_of_the_heuristic(world: World, camp: Camp) -> None:
    """The fastest ways can be said in two layers of 64."""
    assert same(by_colour(world, fastest_way_network(), camp), by_colour(world, "heuristic", camp))


def test_both_camps_may_be_led_by_callables(world: World) -> None:
    led = played_out(seated(world, Picker(nearest_way), Picker(nearest_way)))
    assert same(led, played_out(seated(world, Picker(), Picker())))


@pytest.mark.parametrize("ways", [True, False])
@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_a_callable_that_answers_like_a_network_plays_its_games(world: World, camp: Camp, ways: bool) -> None:
    """A network that was trained without ways reads none in the loop, a callable always has them."""
    network = random_lower(3, ways=ways)

    def lower(states: States, masks: Masks) -> NDArray[np.int64]:
        states = states.copy()
        if not ways:
            states[:, WAYS] = 0.0
        return network(states, masks)

    games = by_colour(world, network, camp)
    assert same(games, by_colour(world, lower, camp))
    assert not same(games, by_colour(world, "heuristic", camp))


def test_every_camp_has_its_own_network(world: World) -> None:
    one, other = random_lower(3), random_lower(4)
    games = played_out(seated(world, Picker(one), Picker(other)))

    assert same(games, played_out(seated(world, Picker(one.__call__), Picker(other.__call__))))
    assert not same(games, played_out(seated(world, Picker(other), Picker(one))))


def led(*pieces: int) -> NDArray[np.bool_]:
    """Some pieces of one game of 14 [1, P]."""
    return np.isin(np.arange(14), pieces)[None]


def two_seats(world: World, piece: int | None) -> Arena:
    """Nobody picks red's tasks but the test, a bot plays blue; `piece`, if any, is led by the test."""
    arena = Arena(world, 1, Terms())
    arena.begin(0, game_seed(7, 0), None, make_player("nearest"))
    if piece is not None:
        arena.lead_outside(ONE, led(piece))
    return arena


def decide(arena: Arena) -> None:
    """Tasks of red by its task sets and the time, if it is due."""
    if arena.due(ONE, Camp.RED)[0]:
        sight = arena.sight(Camp.RED)
        arena.look(ONE, ONE, np.array([Camp.RED]), sight)
        arena.choose(ONE, ONE, np.array([Camp.RED]), Picker().act(sight.obs), sight)


ONE = np.zeros(1, np.int64)


def questions(arena: Arena, piece: int) -> list[int]:
    """Ticks at which the piece's lower level is asked, by a loop that is cut at every tick."""
    arena.drives[0].asked[Camp.BLUE], arena.drives[0].period[Camp.BLUE] = 1, 1
    found: list[int] = []
    mission = arena.missions[0, piece]
    while not arena.over(ONE)[0]:
        decide(arena)
        arena.advance(ONE)
        if asks(mission) and mission.asked_at >= 0 and mission.asked_at not in found[-1:]:
            found.append(int(mission.asked_at))
    return found


def answer_like_heuristic(arena: Arena, piece: int) -> NDArray[np.int64]:
    return nearest_way(*arena.look_routes(ONE, np.array([piece]), ways=True))


@pytest.mark.parametrize("name", ["tank0", "aerocraft0"])
def test_the_loop_stops_exactly_where_a_piece_led_from_outside_asks(world: World, name: str) -> None:
    """At a cell's centre, on arrival or with a task just given; nowhere else, and for nobody else."""
    i = world.piece_names(Camp.RED).index(name)
    arena, stops = two_seats(world, i), []
    piece, mission = arena.state.pieces[0, i], arena.missions[0, i]
    while not arena.over(ONE)[0]:
        decide(arena)
        arena.advance(ONE)
        if arena.drives.waiting[0].any():
            tick = int(arena.state.games[0].tick)
            stops.append(tick)
            assert arena.waiting(0, Camp.RED).tolist() == [i]
            assert piece.arrives_at == NEVER
            assert piece.arrived_at == tick or mission.chosen_at == tick
            assert mission.state != ENDED
            assert asks(mission)
            arena.tell(ONE, np.array([i]), answer_like_heuristic(arena, i))

    assert stops == questions(two_seats(world, None), i)
    assert len(stops) > 10


def test_a_loop_that_waits_can_be_entered_again_and_restored(world: World) -> None:
    """Without an answer it comes back to the very same state; with one, the game is the undisturbed one."""
    pieces = range(7)
    arena, other = two_seats(world, None), two_seats(world, None)
    for one in (arena, other):
        one.lead_outside(ONE, led(*pieces))
    waits = 0
    while not arena.over(ONE)[0]:
        decide(arena)
        arena.advance(ONE)
        waiting = arena.waiting(0, Camp.RED)
        if waiting.size:
            waits += 1
            before = arena.snapshot()
            arena.advance(ONE)
            assert same(before, arena.snapshot())
            other.restore(before)
            arena, other = other, arena
            at = np.zeros(len(waiting), np.int64)
            arena.tell(at, waiting, nearest_way(*arena.look_routes(at, waiting, ways=True)))
    undisturbed = two_seats(world, None)
    while not undisturbed.over(ONE)[0]:
        decide(undisturbed)
        undisturbed.advance(ONE)

    end, expected = arena.snapshot(), undisturbed.snapshot()
    assert same({name: end[name] for name in PLAYED}, {name: expected[name] for name in PLAYED})
    assert waits > 50


def test_a_piece_that_is_let_go_is_led_by_its_camps_lower_level_again(world: World) -> None:
    arena = two_seats(world, 0)
    decide(arena)
    arena.advance(ONE)
    assert arena.waiting(0, Camp.RED).tolist() == [0]

    arena.lead_outside(ONE, led())
    while not arena.over(ONE)[0]:
        decide(arena)
        arena.advance(ONE)
        assert not arena.drives.waiting[0].any()

    expected = two_seats(world, None)
    while not expected.over(ONE)[0]:
        decide(expected)
        expected.advance(ONE)
    assert same(
        {name: arena.snapshot()[name] for name in PLAYED},
        {name: expected.snapshot()[name] for name in PLAYED},
    )


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda mask: mask[:1, 0].repeat(len(mask) + 1), r"1 whole numbers, one a row, got int8 \(2,\)"),
        (lambda mask: mask, r"1 whole numbers, one a row, got int8 \(1, 7\)"),
        (lambda mask: mask.argmax(axis=1) * 1.0, r"1 whole numbers, one a row, got float64 \(1,\)"),
        (lambda _: None, r"1 whole numbers, one a row, got object \(\)"),
        (lambda mask: np.full(len(mask), 7), r"valid answers by the masks, got \[7\]"),
        (lambda mask: np.full(len(mask), -1), r"valid answers by the masks, got \[-1\]"),
        (lambda mask: mask.argmin(axis=1), r"valid answers by the masks, got \[0\]"),
    ],
)
def test_answers_that_are_none_are_refused(answer: Callable[[Masks], Any], message: str) -> None:
    """The tank alone asks; staying is not valid, for its goal is elsewhere."""
    lane = make_lane(Camp.RED)
    assign(lane.missions[0, 1], TaskKind.STOP, NO_PIECE, NO_CELL, 0)
    lane.set_lower(0, Camp.RED, lambda _, masks: answer(masks))

    with pytest.raises(ConfigError, match=message):
        lane.advance(ONE)


LANE = """
    map   plain-12x5
    red   tank 0603
    red   soldier 0605
"""


def make_lane(camp: Camp) -> Arena:
    """A tank and a soldier of one camp, sent to a far corner; nobody decides again."""
    text = LANE if camp == Camp.RED else LANE.replace("red", "blue")
    arena = Arena(load_world(parse_board(text).scenario), 1, Terms(decision_ticks=1800, spots=0))
    arena.begin(0, 1, None, None)
    for i in range(2):
        assign(arena.missions[0, i], TaskKind.HOLD, NO_PIECE, CellIndex(11 if camp == Camp.BLUE else 0), 0)
    arena.drives[0].due[:], arena.drives[0].fresh[:] = 0, 1
    return arena


def keep(arena: Arena, camp: Camp, *answers: int) -> None:
    arena.keep_answers(ONE, np.array([camp]), np.array([answers]))


def names(arena: Arena) -> list[str]:
    hexmap = arena.world.scenario.hexmap
    return [hexmap.cell_name(int(cell)) for cell in arena.state.pieces[0].cell]


@pytest.mark.parametrize(("camp", "edge"), [(Camp.RED, "1203"), (Camp.BLUE, "0103")])
def test_a_kept_direction_is_followed_until_it_is_illegal_wherever_the_goal_is(camp: Camp, edge: str) -> None:
    """In the camp's frame: blue's east is west. The soldier is told to stay."""
    lane = make_lane(camp)
    keep(lane, camp, 1 + E, STAY)

    lane.advance(ONE)

    assert names(lane) == [edge, "0605"]
    assert lane.missions[0].state.tolist() == [STAYING, STAYING]
    assert lane.drives[0].lower[camp] == KEPT


def test_an_illegal_direction_stands_for_staying() -> None:
    lane = make_lane(Camp.RED)
    keep(lane, Camp.RED, STAY, 1 + SE)

    lane.advance(ONE)

    assert names(lane) == ["0603", "0605"]


def test_kept_answers_hold_until_they_are_given_anew_or_another_game_begins() -> None:
    lane = make_lane(Camp.RED)
    keep(lane, Camp.RED, 1 + E, STAY)
    keep(lane, Camp.RED, 1 + W, STAY)
    lane.advance(ONE)
    assert names(lane) == ["0103", "0605"]

    keep(lane, Camp.RED, 1 + W, 1 + W)
    lane.begin(0, 1, None, None)
    assert lane.drives[0].lower.tolist() == [HEURISTIC, HEURISTIC]
    assert not lane.drives[0].kept.any()


SCRIPT = """
import hashlib, runpy, sys
import numpy as np
names = runpy.run_path(sys.argv[1])
lane, lower = names["make_lane"](1), names["random_lower"](3)
lane.set_lower(0, 1, lower)
lane.drives[0].period[:] = 100
lane.advance(np.zeros(1, np.int64))
digest = hashlib.sha256(lane.state.pieces.tobytes() + lane.missions.tobytes() + lane.drives.tobytes())
digest.update(lower.q_values(names["random_states"](5)).tobytes())
print(digest.hexdigest(), *names["names"](lane))
"""


@pytest.mark.timeout(300)
def test_compiled_and_plain_python_agree_to_the_bit() -> None:
    """A tank that a network leads for a while, and values of its network."""
    found = []
    for disable_jit in ("0", "1"):
        env = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
        command = [sys.executable, "-c", SCRIPT, __file__]
        found.append(subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout)

    assert found[0] == found[1]
    assert found[0].split()[1:] != ["0603", "0605"]
