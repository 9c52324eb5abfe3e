"""What is wrong with a bad file that was taken."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from time import process_time
from typing import Any, TypeVar
from zipfile import BadZipFile

import numpy as np

from tests.attack.archives import from_npy, unzipped

Attempt = Callable[[Path], object]
LONG_PHASE = 20_000  # ticks
MAX_GAME_STEPS = 8  # env steps of a game of 300 ticks, and some


ACTS: list[float] = []
"""Seconds of the processor that a user's single acts took, of the file at hand; empty: they are not told apart."""
T = TypeVar("T")


def act(use: Callable[[], T]) -> T:
    """Do what a user does at once, and note how long it took."""
    start = process_time()
    try:
        return use()
    finally:
        ACTS.append(process_time() - start)


class Wrong(Exception):  # noqa: N818  # it is no error of a program
    """A bad file was taken."""


def check(right: bool, reason: str) -> None:
    """Raise Wrong unless it is right."""
    if not right:
        raise Wrong(reason)


def said(data: bytes) -> Any:
    """JSON as the file has it; a file that two readers would read differently must not be taken."""
    try:
        return json.loads(data.decode("utf-8"), object_pairs_hook=_once, parse_constant=_no_number)
    except ValueError as error:
        raise Wrong(f"taken although it is no strict JSON: {error}") from error


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    check(len(values) == len(pairs), "a key twice was taken")
    return values


def _no_number(text: str) -> float:
    raise Wrong(f"{text} was taken")


def check_said(values: Any, taken: Any, place: str = "") -> None:
    """Whether what was taken is what the file says, key by key, type by type."""
    if isinstance(values, dict) and isinstance(taken, dict):
        for key, value in values.items():
            check(key in taken, f"{place}{key[:40]} was passed over in silence")
            check_said(value, taken[key], f"{place}{key[:40]}.")
        return
    found, expected = (json.dumps(one, sort_keys=True, default=str) for one in (taken, values))
    check(found == expected, f"{place[:-1]} is {expected[:60]} in the file, was taken as {found[:60]}")


def finite(*values: Any) -> bool:
    """Whether all numbers of some arrays are finite and real."""
    return all(
        np.asarray(one).dtype.kind in "fiub" and bool(np.isfinite(np.asarray(one, float)).all())
        for one in values
    )


def play(env: Any, model: Any = None, steps: int = MAX_GAME_STEPS) -> None:
    """Play some steps, and look at all that comes."""
    obs = env.reset() if model is None or model._last_obs is None else model._last_obs
    for _ in range(steps):
        for key, space in env.observation_space.spaces.items():
            for one in obs[key]:
                check(space.contains(one), f"the observation {key} is not in its space")
        actions = (
            obs["action_mask"].argmax(-1) if model is None else model.predict(obs, deterministic=True)[0]
        )
        obs, reward, done, infos = env.step(actions)
        check(finite(reward), f"rewards {reward}")
        for ended in np.flatnonzero(done):
            margin = infos[ended].get("margin", 0)
            check(abs(margin) <= _most_margin(env), f"a game ended with a margin of {margin}")


def _most_margin(env: Any) -> float:
    scenario = env.unwrapped.games.arena.world.scenario if hasattr(env.unwrapped.games, "arena") else None
    points = sum(point.value for point in scenario.points) if scenario else 1e6
    return float(points + 1000)


def arrays_of(path: Path) -> dict[str, Any]:
    """Arrays of a file that was taken, by numpy, wherever in the file the archive begins."""
    try:
        entries = unzipped(path.read_bytes())
        return {name.removesuffix(".npy"): from_npy(body) for name, body in entries.items()}
    except (ValueError, EOFError, BadZipFile) as error:
        raise Wrong(f"taken although an entry is no array: {error}") from error


def check_alike(taken: Mapping[str, Any], good: Mapping[str, Any], *, strict: bool = True) -> None:
    """Arrays have the types and the shapes of those of a valid file; or numbers alone."""
    for name, array in good.items():
        check(name in taken, f"it has no {name}, and was taken")
        found = taken[name]
        kinds = "iuf" if not strict else "U" if array.dtype.kind == "U" else ""
        alike = found.dtype.kind in kinds if kinds else found.dtype == array.dtype
        check(alike, f"{name} of the type {str(found.dtype)[:40]} was taken")
        check(not strict or found.shape == array.shape, f"{name} of the shape {found.shape} was taken")
        check(array.dtype.kind != "f" or finite(found), f"{name} that is not finite was taken")


def check_finite(model: Any) -> None:
    import torch

    finite_now = all(bool(torch.isfinite(tensor).all()) for tensor in model.policy.state_dict().values())
    check(finite_now, "it learned numbers that are not finite")


def learn(model: Any, steps: int) -> None:
    """Learn a little, unless the file asks for phases of the lower level that take their time."""
    if getattr(model, "phase_ticks", (0, 0))[1] <= LONG_PHASE:
        model.learn(steps, reset_num_timesteps=False)
    check_finite(model)
