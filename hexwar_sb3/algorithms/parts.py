"""Parts of a checkpoint: named arrays, grouped by prefixes; the running games of an env."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor

Arrays = dict[str, NDArray[Any]]
MONITOR_SUMS = ("episode_returns", "episode_lengths")


def under(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """Put every name under a prefix.

    Example:
        >>> list(under("games", {"tick": tick}))
        ['games/tick']
    """
    return {f"{prefix}/{name}": array for name, array in arrays.items()}


def part(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """Take back what `under` put there."""
    start = f"{prefix}/"
    return {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}


def env_snapshot(env: VecEnv | None) -> Arrays:
    """Snapshot of the env and the sums of its monitor; nothing if it cannot give one."""
    if env is None or not hasattr(env.unwrapped, "snapshot"):
        return {}
    sums = {f"monitor_{name}": getattr(monitor, name) for monitor in _monitors(env) for name in MONITOR_SUMS}
    return {**sums, **under("games", env.unwrapped.snapshot())}


def restore_env(env: VecEnv, arrays: Arrays) -> None:
    """Put the env and its monitor back to where `env_snapshot` was taken."""
    for monitor in _monitors(env):
        for name in MONITOR_SUMS:
            setattr(monitor, name, arrays[f"monitor_{name}"].copy())
    env.unwrapped.restore(part("games", arrays))  # type: ignore[attr-defined]


def _monitors(env: VecEnv) -> list[VecMonitor]:
    """The env's VecMonitor, if it has one."""
    while isinstance(env, VecEnvWrapper):
        if isinstance(env, VecMonitor):
            return [env]
        env = env.venv
    return []
