"""Breaks snapshots of running games in every field, one by one, and says what the envs made of them.

Run as a program, so that a crash of the process is seen: `python broken_snapshots.py KIND PART OF`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.play.recording import record_game

Snapshot = dict[str, NDArray[Any]]


class Picker:
    """An opponent that is no bot: the last valid task of every piece."""

    def act(self, obs: Any) -> NDArray[np.int64]:
        mask = np.asarray(obs["action_mask"])
        return np.asarray(mask.shape[-1] - 1 - mask[..., ::-1].argmax(axis=-1))


def first_way(_: NDArray[Any], masks: NDArray[Any]) -> NDArray[np.int64]:
    """A lower level from outside: the first valid answer."""
    return np.asarray(masks.argmax(axis=1))


KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "red": ("HexWarTask-v0", {"side": "red", "opponent": ["MA1", "random"]}),
    "blue": (
        "HexWarTask-v0",
        {"side": "blue", "opponent": Picker(), "lower": first_way, "scenario": "hills"},
    ),
    "both": (
        "HexWarTask-v0",
        {"side": "both", "opponent": [Picker(), "drawn-unseen"], "demo": "MA1", "demo_share": 0.5},
    ),
    "recorded": ("HexWarTask-v0", {"side": "both", "opponent": "MA1", "demo_share": 1.0, "n_envs": 4}),
    "route": ("HexWarRoute-v0", {"opponent": ["MA1", Picker()], "scenario": ["plain", "paddy"], "n_envs": 4}),
    "flat": ("HexWarFlat-v0", {"side": "both", "opponent": "drawn"}),
}
STEPS = {"route": 60, "flat": 60}  # into the games; else so many decisions:
DECISIONS = 13


@cache
def recorded_games() -> Path:
    """A folder of games for this process: two bots', and one of people who gave an order."""
    folder = Path(_folder().name)
    record_game("MA2", "MA1", seed=1).save(folder / "bots.hwr")
    game = Game("plain")
    game.submit("red", "tank0 move E E E")
    game.advance(1800)
    Replay.of(game).save(folder / "people.hwr")
    return folder


@cache
def _folder() -> TemporaryDirectory[str]:
    return TemporaryDirectory()


def native(kind: str) -> Any:
    name, options = KINDS[kind]
    if kind == "recorded":
        options = {**options, "demo": recorded_games()}
    return make_vec_env(name, **{"n_envs": 2, "seed": 3, **options}).unwrapped


def play(env: Any, obs: Any, steps: int, rng: np.random.Generator) -> Any:
    for _ in range(steps):
        mask = obs["action_mask"] if isinstance(obs, dict) else env.action_masks()
        obs, *_ = env.step((rng.random(mask.shape) * (mask != 0)).argmax(axis=-1))
    return obs


def is_fine(env: Any, obs: Any) -> bool:
    if not isinstance(obs, dict):
        return all(env.observation_space.contains(row) for row in obs)
    rows = ({key: value[b] for key, value in obs.items()} for b in range(env.num_envs))
    return all(env.observation_space.contains(row) for row in rows)


def ends_of(dtype: np.dtype[Any]) -> list[Any]:
    """Both ends of a type, and what is no number."""
    if dtype.kind in "iu":
        info = np.iinfo(dtype)
        return [info.min, info.max]
    if dtype.kind == "f":
        return [np.finfo(dtype).min, np.finfo(dtype).max, np.nan, np.inf, -np.inf]
    return [False, True] if dtype.kind == "b" else []


def leaves(dtype: np.dtype[Any]) -> list[tuple[str, ...]]:
    """Names that lead to each field of a record, of records within it too."""
    if dtype.names is None:
        return [()]
    return [(name, *path) for name in dtype.names for path in leaves(dtype[name].base)]


def at(array: NDArray[Any], path: tuple[str, ...]) -> NDArray[Any]:
    for name in path:
        array = array[name]
    return array


def broken(snapshot: Snapshot, rng: np.random.Generator) -> Iterator[tuple[str, Snapshot]]:
    """Snapshots with one thing changed, and what it is."""
    for name, array in snapshot.items():
        for path in leaves(array.dtype):
            plain = at(array, path)
            for value in ends_of(plain.dtype):
                for everywhere in (False, True):
                    if not plain.size:
                        continue  # a log of no events
                    changed = array.copy()
                    where = ... if everywhere else tuple(rng.integers(0, n) for n in plain.shape)
                    at(changed, path)[where] = value
                    if same(changed, array):
                        continue
                    yield (
                        f"{'.'.join([name, *path])} = {value}{'' if everywhere else ' once'}",
                        {**snapshot, name: changed},
                    )
        yield f"{name} missing", {key: value for key, value in snapshot.items() if key != name}
        yield f"{name} of objects", {**snapshot, name: np.full(array.shape, None)}
        yield f"{name} as text", {**snapshot, name: np.full(array.shape, "x" * 5000)}
        yield f"{name} as floats", {**snapshot, name: np.zeros(array.shape)}
        if array.dtype.newbyteorder(">") != array.dtype:
            yield (
                f"{name} big-endian",
                {**snapshot, name: np.zeros(array.shape, array.dtype.newbyteorder(">"))},
            )
        yield f"{name} one axis more", {**snapshot, name: array[None]}
        if array.ndim:
            yield f"{name} one fewer", {**snapshot, name: array[:-1]}
            yield f"{name} one more", {**snapshot, name: np.concatenate([array, array[:1]])}
            if not same(array[::-1], array):
                yield f"{name} turned round", {**snapshot, name: array[::-1].copy()}
    if all(array.ndim for array in snapshot.values()):
        yield "one game fewer", {name: array[:-1] for name, array in snapshot.items()}
    yield "an unknown array", {**snapshot, "more": np.zeros(3)}


def whole_game(kind: str) -> int:
    """Steps that end every game."""
    return 400 if kind in STEPS else 26


def report(kind: str, part: int, of: int) -> dict[str, Any]:
    """Try every part-th broken snapshot, and play on from those that are accepted."""
    rng, env = np.random.default_rng(part), native(kind)
    play(env, env.reset(), STEPS.get(kind, DECISIONS), np.random.default_rng(0))
    true = env.snapshot()
    found: dict[str, Any] = {"tried": 0, "refused": 0, "accepted": [], "wrong": []}
    for k, (what, snapshot) in enumerate(broken(true, rng)):
        if k % of != part:
            continue
        found["tried"] += 1
        try:
            obs = env.restore(snapshot)
        except HexWarError:
            found["refused"] += 1
            after = env.snapshot()
            if any(not same(after[name], array) for name, array in true.items()):
                found["wrong"].append(f"{what}: refused, but the env is another one")
            continue
        except Exception as error:  # noqa: BLE001  # whatever it is, it is not ours
            found["wrong"].append(f"{what}: {type(error).__name__}: {error}")
            continue
        found["accepted"].append(what)
        sys.stderr.write(f"playing on: {what}\n")  # the last line before a crash
        try:
            if not is_fine(env, play(env, obs, whole_game(kind), rng)) or not is_fine(env, obs):
                found["wrong"].append(f"{what}: an observation outside its space")
        except Exception as error:  # noqa: BLE001
            found["wrong"].append(f"{what}: then {type(error).__name__}: {error}")
        env.restore(true)
    return found


def same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return one.dtype == other.dtype and np.array_equal(one, other)


if __name__ == "__main__":
    json.dump(report(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])), sys.stdout)
