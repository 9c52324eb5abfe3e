"""How fast games are played: the engine, the bots, the env."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from time import process_time

import numpy as np

from hexwar_sb3.bots.act import think
from hexwar_sb3.bots.registry import Bot
from hexwar_sb3.engine.batch import Engine
from hexwar_sb3.engine.pieces import has_path
from hexwar_sb3.engine.step import advance_by_ticks
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import NO_DIRECTION
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.match import play_games
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, fastest_way_network
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import CampIndex, CellIndex
from hexwar_sb3.tasks.travel import next_direction

Round = Callable[[int], tuple[float, float]]  # number of the round -> amount done, seconds

GAMES = 64  # of an engine or bot round
LEG_TICKS = 600  # between two goals of a piece: about the way to a control point
ENV_GAMES = 16  # of an env round
THOUGHTS = 50  # about the same position
ROUTE_GAMES, ROUTE_STEPS = 48, 100  # of a route env round, as the lower level trains
ENV_STEPS = 480  # env steps of a round, each of all games


def game_figures(scenario: str, rounds: int) -> dict[str, float]:
    """Measure ticks and env steps a second of process time."""
    world = load_world(scenario)
    engine = best(lambda k: routes_round(scenario, k), rounds)
    tick_by_tick = best(lambda k: routes_round(scenario, k, by_ticks=True), rounds)
    tasks = best(lambda k: tasks_round(world, k), rounds)
    bots = best(lambda k: bots_round(scenario, k), rounds)
    return {
        "engine_leg_ticks": LEG_TICKS,
        "engine_ticks_per_s": engine,
        "engine_piece_ticks_per_s": engine * world.n_pieces,
        "engine_tick_by_tick_ticks_per_s": tick_by_tick,
        "tasks_ticks_per_s": tasks,
        "bots_ticks_per_s": bots,
        "bots_piece_ticks_per_s": bots * world.n_pieces,
        "bot_thought_us": thought_us(world),
        "task_env_steps_per_s": best(lambda k: env_round(scenario, k), rounds),
        "task_env_net_steps_per_s": best(lambda k: env_round(scenario, k, fastest_way_network()), rounds),
        "route_env_steps_per_s": best(lambda k: route_round(scenario, k), rounds),
    }


def best(measure: Round, rounds: int) -> float:
    """Highest rate of several rounds; an unmeasured one goes first and compiles."""
    measure(0)
    return max(amount / seconds for amount, seconds in map(measure, range(1, rounds + 1)))


def tasks_round(world: World, seed: int) -> tuple[float, float]:
    """Play games in which both camps pick random tasks; only engine, routes and task execution are timed."""
    arena = Arena(world, GAMES, Terms())
    for b in range(GAMES):
        arena.begin(b, seed * GAMES + b, None, None)
    sights = [Sight(world, GAMES) for _ in (Camp.RED, Camp.BLUE)]
    rng, which, seconds = np.random.default_rng(seed), np.arange(GAMES), 0.0
    while which.size:
        for camp, sight in enumerate(sights):
            choose_randomly(arena, which, camp, sight, rng)
        start = process_time()
        arena.advance(which)
        seconds += process_time() - start
        which = which[~arena.over(which)]
    return float(arena.state.games.tick.sum()), seconds


def choose_randomly(
    arena: Arena, which: np.ndarray, camp: int, sight: Sight, rng: np.random.Generator
) -> None:
    """Give every piece of a camp a random valid task."""
    slots, camps = np.arange(which.size), np.full(which.size, camp)
    arena.look(slots, which, camps, sight)
    mask = sight.obs["action_mask"][: which.size]
    arena.choose(slots, which, camps, (rng.random(mask.shape) * mask).argmax(axis=-1), sight)


def bots_round(scenario: str, seed: int) -> tuple[float, float]:
    """Play MA1 against MA2, whole games."""
    start = process_time()
    outcome = play_games("MA1", "MA2", GAMES, Terms(scenario=scenario), seed)
    return float(outcome.ticks.sum()), process_time() - start


def thought_us(world: World) -> float:
    """Play MA1 against MA2, and measure the median process time of a regular thought, in microseconds."""
    arena, first = Arena(world, 1, Terms()), np.array([0])
    arena.begin(0, 0, make_player("MA1"), make_player("MA2"))
    arena.drives.asked[0] = 1  # stops at every regular thought
    repeat_thought(1, Camp.RED, Bot.ATTACK, *_thinker(arena))  # compiles
    times = []
    while not arena.over(first)[0]:
        for camp, bot in ((Camp.RED, Bot.ATTACK), (Camp.BLUE, Bot.DEFENCE)):
            before = arena.snapshot()
            start = process_time()
            repeat_thought(THOUGHTS, camp, bot, *_thinker(arena))
            times.append((process_time() - start) / THOUGHTS * 1e6)
            arena.restore(before)
        arena.advance(first)
    return float(np.median(times))


def _thinker(arena: Arena) -> tuple[Rows, ...]:
    state, world = arena.state, arena.world
    return (
        state.games[0], state.pieces[0], state.memory[0], state.rounds[0], arena.missions[0], arena.brains[0],
        world.rules[0], world.cells, world.los, world.eta, arena.atlas[0],
    )  # fmt: skip


@kernel
def repeat_thought(
    times: int, camp: CampIndex, bot: int, game: Row, pieces: Rows, memory: Rows, rounds: Rows, missions: Rows,
    brains: Rows, rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Let a full player think about the same position again and again."""
    for _ in range(times):
        brains[camp].thoughts += 1
        think(
            atlas.style[bot], camp, game, pieces, memory, rounds, missions, brains[camp],
            rules, cells, los, eta, atlas,
        )  # fmt: skip


def routes_round(scenario: str, seed: int, *, by_ticks: bool = False) -> tuple[float, float]:
    """Play games in which every piece walks the cheapest way to random cells; only the engine is timed."""
    engine = Engine(scenario, GAMES)
    world = engine.world
    engine.reset(range(seed * GAMES, (seed + 1) * GAMES))
    rng, seconds, state = np.random.default_rng(seed), 0.0, engine.state
    for tick in range(0, world.scenario.game_ticks, LEG_TICKS):
        goals = rng.choice(np.flatnonzero(world.cells.passable), state.orders.shape)
        order_walks(goals, state.games, state.pieces, state.orders, world.rules[0], world.cells, world.eta)
        until = np.full(GAMES, tick + LEG_TICKS)
        start = process_time()
        if by_ticks:
            make_every_step(until, *(getattr(state, field.name) for field in fields(state)), *world.tables)
        else:
            engine.advance(LEG_TICKS)
        seconds += process_time() - start
    return float(state.games.tick.sum()), seconds


@kernel
def order_walks(
    goals: Rows, games: Rows, pieces: Rows, orders: Rows, rules: Row, cells: Rows, eta: Rows
) -> None:
    """Order every piece that has no path to walk the cheapest way to its goal, goals [B, P]."""
    for b in range(games.size):
        for i in range(pieces.shape[1]):
            piece, order = pieces[b, i], orders[b, i]
            if has_path(piece):
                continue
            order.kind = int(Action.MOVE)
            order.path_len = 0
            cell = CellIndex(piece.cell)
            while order.path_len < rules.path_limit:
                d = next_direction(piece.kind, piece.camp, cell, goals[b, i], False, rules, cells, eta)
                if d == NO_DIRECTION:
                    break
                order.path[order.path_len] = d
                order.path_len += 1
                cell = CellIndex(cells[cell].neighbour[d])


@kernel
def make_every_step(
    until: Rows, games: Rows, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows,
    log: Rows, rules: Row, cells: Rows, los: Rows,
) -> None:  # fmt: skip
    """Play game b to tick until[b] step by step, for all b."""
    for b in range(games.size):
        advance_by_ticks(
            until[b], games[b], pieces[b], memory[b], paths[b], rounds[b], orders[b], log[b], rules,
            cells, los,
        )  # fmt: skip


def env_round(scenario: str, seed: int, lower: object = HEURISTIC_LOWER) -> tuple[float, float]:
    """Step the task env's native VecEnv with random valid tasks against MA1."""
    env = make_vec_env(
        "HexWarTask-v0", n_envs=ENV_GAMES, seed=seed, scenario=scenario, opponent="MA1", lower=lower
    )
    rng, obs = np.random.default_rng(seed), env.reset()
    start = process_time()
    for _ in range(ENV_STEPS):
        mask = obs["action_mask"]  # type: ignore[call-overload]  # a Dict env gives a dict
        obs, _, _, _ = env.step((rng.random(mask.shape, np.float32) * mask).argmax(axis=-1))
    return float(ENV_STEPS * ENV_GAMES), process_time() - start


def route_round(scenario: str, seed: int) -> tuple[float, float]:
    """Step the route env's native VecEnv along the fastest ways."""
    env = make_vec_env("HexWarRoute-v0", n_envs=ROUTE_GAMES, seed=seed, scenario=scenario)
    lead, obs = fastest_way_network(), env.reset()
    start = process_time()
    for _ in range(ROUTE_STEPS):
        obs, _, _, _ = env.step(lead(obs["obs"], obs["action_mask"]))  # type: ignore[call-overload]
    return float(ROUTE_STEPS * ROUTE_GAMES), process_time() - start
