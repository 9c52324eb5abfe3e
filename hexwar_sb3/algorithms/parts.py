"""Parts of a checkpoint: named arrays, grouped by prefixes; the running games of an env."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor

Arrays = dict[str, NDArray[Any]]

MONITOR_SUMS = ("episode_returns", "episode_lengths")


@dataclass(frozen=True)
class Joined:
    """Arrays that are one in a file, along their first axis, and never lie in memory twice."""

    arrays: Sequence[NDArray[Any]]  # at least one, of one type

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Join them."""
        return np.concatenate(self.arrays).astype(dtype or self.arrays[0].dtype, copy=False)

    def write(self, file: BinaryIO) -> None:
        """Write them as one `.npy`."""
        first = self.arrays[0]
        shape = (sum(len(array) for array in self.arrays), *first.shape[1:])
        head = {"descr": npy.dtype_to_descr(first.dtype), "fortran_order": False, "shape": shape}
        npy.write_array_header_1_0(file, head)
        file.writelines(array.tobytes() for array in self.arrays)


def write_arrays(file: BinaryIO, arrays: Mapping[str, Any]) -> None:
    """Write what `np.savez` writes, one array after the other; a `Joined` needs no memory of its own."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                if isinstance(array, Joined):
                    array.write(entry)  # type: ignore[arg-type]
                else:
                    npy.write_array(entry, np.asanyarray(array), allow_pickle=False)


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
