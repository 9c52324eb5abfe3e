"""How fast games are played: the engine, the bots, the env."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time

import numpy as np

from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.step import advance, advance_by_ticks
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.play.arena import Arena, Setup
from hexwar_sb3.play.look import Sight
from hexwar_sb3.play.match import play_games
from hexwar_sb3.rules.enums import Camp

Round = Callable[[int], tuple[float, float]]  # number of the round -> amount done, seconds

GAMES = 64  # of an engine or bot round
ENV_GAMES = 16  # of an env round
ENV_STEPS = 480  # env steps of a round, each of all games


def game_figures(scenario: str, rounds: int) -> dict[str, float | None]:
    """Measure ticks and env steps a second of process time."""
    world = load_world(scenario)
    engine = best(lambda k: tasks_round(world, k), rounds)
    bots = best(lambda k: bots_round(scenario, k), rounds)
    events = best(lambda k: walk_round(world, k, by_ticks=False), rounds)
    ticks = best(lambda k: walk_round(world, k, by_ticks=True), rounds)
    return {
        "engine_ticks_per_s": engine,
        "engine_piece_ticks_per_s": engine * world.n_pieces,
        "bots_ticks_per_s": bots,
        "bots_piece_ticks_per_s": bots * world.n_pieces,
        "event_driven_ticks_per_s": events,
        "tick_by_tick_ticks_per_s": ticks,
        "task_env_steps_per_s": best(lambda k: env_round(scenario, k), rounds),
        "task_env_net_steps_per_s": None,  # needs a network as lower policy
    }


def best(measure: Round, rounds: int) -> float:
    """Highest rate of several rounds; an unmeasured one goes first and compiles."""
    measure(0)
    return max(amount / seconds for amount, seconds in map(measure, range(1, rounds + 1)))


def tasks_round(world: World, seed: int) -> tuple[float, float]:
    """Play games in which both camps pick random tasks; only the engine with its routes is timed."""
    arena = Arena(world, GAMES, Setup())
    for b in range(GAMES):
        arena.begin(b, seed * GAMES + b, None, None)
    sights = [Sight(world, camp, GAMES) for camp in (Camp.RED, Camp.BLUE)]
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
    outcome = play_games("MA1", "MA2", GAMES, scenario, seed)
    return float(outcome.ticks.sum()), process_time() - start


def walk_round(world: World, seed: int, *, by_ticks: bool) -> tuple[float, float]:
    """Let games run out after the orders of one random decision, event by event or tick by tick."""
    arena = Arena(world, GAMES, Setup())
    rng, which = np.random.default_rng(seed), np.arange(GAMES)
    for b in range(GAMES):
        arena.begin(b, seed * GAMES + b, None, None)
    for camp in (Camp.RED, Camp.BLUE):
        choose_randomly(arena, which, camp, Sight(world, camp, GAMES), rng)
    arena.advance(which)
    start = process_time()
    run_out(world, arena.state, by_ticks=by_ticks)
    return float(arena.state.games.tick.sum()), process_time() - start


def run_out(world: World, state: State, *, by_ticks: bool) -> None:
    """Play games to their ends without further orders."""
    run = advance_by_ticks if by_ticks else advance
    for b in range(len(state.games)):
        run(
            int(state.games[b].end_tick), state.games[b], state.pieces[b], state.memory[b], state.paths[b],
            state.rounds[b], state.orders[b], state.log[b], world.rules[0], world.cells, world.los,
        )  # fmt: skip


def env_round(scenario: str, seed: int) -> tuple[float, float]:
    """Step the task env's native VecEnv with random valid tasks against MA1."""
    env = make_vec_env("HexWarTask-v0", n_envs=ENV_GAMES, seed=seed, scenario=scenario, opponent="MA1")
    rng, obs = np.random.default_rng(seed), env.reset()
    start = process_time()
    for _ in range(ENV_STEPS):
        mask = obs["action_mask"]  # type: ignore[call-overload]  # a Dict env gives a dict
        obs, _, _, _ = env.step((rng.random(mask.shape, np.float32) * mask).argmax(axis=-1))
    return float(ENV_STEPS * ENV_GAMES), process_time() - start
