"""A copy of anything that plays, made in any way, goes on in the same way and compiles nothing anew."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any, cast

import cloudpickle
import gymnasium
import joblib
import numpy as np
import pytest
from stable_baselines3.common.vec_env import SubprocVecEnv

from hexwar_sb3.bots.atlas import make_atlas
from hexwar_sb3.engine.batch import Engine
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Move
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.flat_env import FlatEnv
from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.route_env import RouteEnv
from hexwar_sb3.envs.task_env import TaskEnv
from hexwar_sb3.kernels import COMPILED, READ, counts
from hexwar_sb3.players.frozen_lower import fastest_way_network
from hexwar_sb3.players.player import Player, make_player

WAYS: dict[str, Callable[[Any], Any]] = {
    "copy.deepcopy": copy.deepcopy,
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),  # noqa: S301
    "pickle, protocol 2": lambda one: pickle.loads(pickle.dumps(one, 2)),  # noqa: S301
    "cloudpickle": lambda one: cloudpickle.loads(cloudpickle.dumps(one)),
    "twice": lambda one: copy.deepcopy(pickle.loads(pickle.dumps(one))),  # noqa: S301
}


def first_valid(mask: np.ndarray, step: int) -> np.ndarray:
    """A valid choice of each row that depends on the mask and the step alone."""
    valid = mask.sum(-1)
    order = np.argsort(1 - mask, axis=-1, kind="stable")
    return np.take_along_axis(order, ((7 * step) % np.maximum(valid, 1))[..., None], -1)[..., 0]


def play_game(game: Game) -> list[Any]:
    game.submit("red", Move("tank0", ["1134"])) if game.tick == 0 else None
    return [game.advance(75), str(game), game.margin("red"), game.legal_orders("blue", "tank0")]


def play_engine(engine: Engine) -> list[Any]:
    if not engine.state.games.tick.any():
        engine.reset(range(len(engine)))
        engine.submit(0, "red", [Move("tank0", ["1134"])])
    engine.advance(75)
    return [engine.margins("red"), engine.state.pieces.tolist(), repr(engine.view(0, "red"))]


def play_env(env: Any) -> list[Any]:
    if not hasattr(env, "last"):
        env.last, env.n_steps = env.reset(seed=3)[0], 0
    seen = []
    for _ in range(3):
        mask = env.action_masks()
        mask = (
            env.last["action_mask"]
            if isinstance(env.last, dict) and env.last["action_mask"].ndim == 2
            else mask
        )
        env.last, *rest = env.step(first_valid(np.asarray(mask, np.int64), env.n_steps))
        env.n_steps += 1
        seen += [env.last, *rest]
    return seen


def play_vec_env(env: Any) -> list[Any]:
    if not hasattr(env, "last"):
        env.last, env.n_steps = env.reset(), 0
    seen = []
    for _ in range(3):
        if isinstance(env.last, dict):
            mask = env.last["action_mask"]
        else:
            mask = np.stack(env.env_method("action_masks"))
        env.last, rewards, dones, _ = env.step(first_valid(np.asarray(mask, np.int64), env.n_steps))
        env.n_steps += 1
        seen += [copy.deepcopy(env.last), rewards, dones]
    return seen


def play_parallel(env: Any) -> list[Any]:
    if not hasattr(env, "last"):
        env.last, env.n_steps = env.reset(seed=3)[0], 0
    seen = []
    for _ in range(3):
        masks = {agent: np.asarray(env.last[agent]["action_mask"]) for agent in env.agents}
        actions = {agent: int(first_valid(mask, env.n_steps)) for agent, mask in masks.items()}
        env.last, rewards, *_ = env.step(actions)
        env.n_steps += 1
        seen += [env.last, rewards]
    return seen


def policy_act(policy: Any) -> list[Any]:
    env = TaskEnv()
    obs, _ = env.reset(seed=1)
    batch = {key: value[None] for key, value in obs.items()}
    return [policy.act(batch), policy.sha256]


def world_tables(world: Any) -> list[Any]:
    tables = [world.cells, world.los, world.rules, make_atlas(world)]
    assert not any(tables[k].flags.writeable for k in (0, 1, 3))
    return [table.tobytes() for table in tables]


def with_networks() -> TaskEnv:
    return TaskEnv(
        opponent=[(make_player("HRL0"), 1), ("MA2", 1)], lower=fastest_way_network(), privileged_state=True
    )


MADE: dict[str, tuple[Callable[[], Any], Callable[[Any], list[Any]]]] = {
    "World": (lambda: load_world("plain"), world_tables),
    "Game": (Game, play_game),
    "Engine": (lambda: Engine(n_games=2), play_engine),
    "TaskEnv": (TaskEnv, play_env),
    "TaskEnv with networks": (with_networks, play_env),
    "TaskEnv in half precision": (lambda: TaskEnv(dtype="float16"), play_env),
    "RouteEnv": (RouteEnv, play_env),
    "FlatEnv": (FlatEnv, play_env),
    "parallel env": (parallel_env, play_parallel),
    "task VecEnv": (lambda: make_vec_env(n_envs=2, seed=1).venv, play_vec_env),
    "route VecEnv": (lambda: make_vec_env("HexWarRoute-v0", n_envs=2, seed=1).venv, play_vec_env),
    "flat VecEnv": (lambda: make_vec_env("HexWarFlat-v0", n_envs=2, seed=1).venv, play_vec_env),
    "FrozenPolicy": (lambda: make_player("HRL0"), policy_act),
}


def bits(value: Any) -> Any:
    """A value in a form that compares bit by bit."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, dict):
        return {key: bits(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [bits(one) for one in value]
    return value


@pytest.mark.parametrize("name", MADE)
def test_a_copy_goes_on_as_the_original_and_compiles_nothing(name: str) -> None:
    make, play = MADE[name]
    one = make()
    play(one)
    copies = {way: copied(one) for way, copied in WAYS.items()}
    seen = bits(play(one))
    seen_later = bits(play(one))
    before = counts[COMPILED] + counts[READ]
    for way, other in copies.items():
        assert bits(play(other)) == seen, way
        assert bits(play(other)) == seen_later, way
    assert counts[COMPILED] + counts[READ] == before


def test_arrays_that_may_not_be_written_compile_nothing() -> None:
    """Actions and observations of other libraries often are read-only."""

    def in_form(writeable: bool) -> list[Any]:
        env, policy, lower = TaskEnv(), cast("Player", make_player("HRL0")), fastest_way_network()
        obs, _ = env.reset(seed=2)
        batch = {key: value[None] for key, value in obs.items()}
        for value in batch.values():
            value.flags.writeable = writeable
        actions = policy.act(batch)[0]
        actions.flags.writeable = writeable
        states, masks = (
            np.ones((3, lower.weights["layer1.weight"].shape[1]), np.float32),
            np.ones((3, 7), np.int8),
        )
        states.flags.writeable = masks.flags.writeable = writeable
        return [actions, lower(states, masks), env.step(actions)[:2]]

    seen = bits(in_form(writeable=True))
    before = counts.copy()
    assert bits(in_form(writeable=False)) == seen
    assert counts == before


def in_worker(env: gymnasium.Env[Any, Any]) -> gymnasium.Env[Any, Any]:
    """An env that tells which kernels its process compiled; its class travels by value."""

    class Counting(gymnasium.Wrapper[Any, Any, Any, Any]):
        def compiled(self) -> int:
            from hexwar_sb3.kernels import counts  # the worker's own: a global would travel by value, too

            return counts[COMPILED]

    return Counting(env)


@pytest.mark.parametrize("start", ["spawn", pytest.param("forkserver", marks=pytest.mark.slow)])
def test_an_env_that_was_sent_to_a_worker_compiles_nothing(start: str) -> None:
    play_env(TaskEnv())  # what it takes is compiled now
    here = TaskEnv()
    obs, _ = here.reset(seed=5)
    actions = first_valid(obs["action_mask"].astype(np.int64), 1)
    sent = in_worker(here)
    away = SubprocVecEnv([lambda: sent], start_method=start)
    try:
        seen, *_ = away.step(actions[None])
        assert away.env_method("compiled") == [0]
    finally:
        away.close()
    assert isinstance(seen, dict)
    assert bits({key: value[0] for key, value in seen.items()}) == bits(here.step(actions)[0])


@pytest.mark.slow
def test_a_game_that_was_sent_to_a_worker_of_joblib_compiles_nothing() -> None:
    Game(seed=4).advance(400)  # what it takes is compiled now
    game = Game(seed=4)
    game.advance(10)

    def played(one: Game) -> tuple[Any, str, int]:
        from hexwar_sb3.kernels import counts  # the worker's own

        return one.advance(300), str(one), counts[COMPILED]

    found = joblib.Parallel(n_jobs=2, backend="loky")(joblib.delayed(played)(game) for _ in range(2))
    here = game.advance(300), str(game), 0
    assert found == [here, here]
