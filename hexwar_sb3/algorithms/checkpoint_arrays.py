"""Parts of a checkpoint: named arrays, grouped by prefixes; the running games of an env; what may be in them."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from gymnasium import spaces
from numpy.lib import format as npy
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor, VecNormalize

from hexwar_sb3.engine.fields import check_all, check_form, check_names, check_range, refuse
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.errors import CheckpointError, HexWarError
from hexwar_sb3.reading import opened, read_arrays

Arrays = dict[str, NDArray[Any]]

MONITOR_SUMS = {"episode_returns": np.float32, "episode_lengths": np.int32}
FLAGS = ("action_mask", "alive")  # parts of an observation that hold 0 and 1 alone
MOST_REWARD = 1e12  # of a step; squares of more would be infinite
_MOST_SUM = 1e30  # of an episode's rewards
_MOST_STEPS = 1 << 30  # of an episode
_CHUNK_ROWS = 1 << 14  # that are looked at together


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


def read_replay(path: str | Path | io.BufferedIOBase) -> Arrays:
    """Read arrays that were saved as a replay.

    Raises:
        CheckpointError: there are none.
    """
    if not isinstance(path, str | Path):
        return read_arrays(cast("BinaryIO", path), "replay", CheckpointError, "a replay")
    with opened(Path(path), CheckpointError, "a replay") as file:
        return read_arrays(file, path, CheckpointError, "a replay")


def under(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """Put every name under a prefix.

    Example:
        >>> import numpy as np
        >>> list(under("games", {"tick": np.zeros(1)}))
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
    """Put the env and its monitor back to where `env_snapshot` was taken.

    Raises:
        CheckpointError: it is broken; env and monitor are as they were.
        ConfigError: it is of another env.
    """
    monitors = _monitors(env)
    sums = {f"monitor_{name}": dtype for name, dtype in MONITOR_SUMS.items()}
    others = {name: array for name, array in arrays.items() if not name.startswith("games/")}
    check_names(others, [name for name in sums if monitors or name in others])
    for name, array in others.items():
        check_form(name, array, sums[name], (env.num_envs,))
        least, most = (0, _MOST_STEPS) if array.dtype.kind == "i" else (-_MOST_SUM, _MOST_SUM)
        check_range(name, array, least, most)
    if not hasattr(env.unwrapped, "restore"):
        refuse("games", "running games", "none: this env cannot go on with them")
    with placed("games"):
        _restore_games(env, part("games", arrays))
    for monitor in monitors:
        for name in MONITOR_SUMS:
            setattr(monitor, name, arrays[f"monitor_{name}"].copy())


def _restore_games(env: VecEnv, games: Arrays) -> None:
    try:
        env.unwrapped.restore(games)  # type: ignore[attr-defined]
    except HexWarError:
        raise
    except (LookupError, ValueError, TypeError, ArithmeticError) as error:  # of an env that is not ours
        refuse("arrays", f"{type(error).__name__}: {error}", "what the env gave")


def check_observation(place: str, found: Arrays, env: VecEnv) -> None:
    """Check the last observation of a VecEnv.

    Raises:
        CheckpointError: it is none.
    """
    boxes = dict(env.observation_space.items())  # type: ignore[attr-defined]
    check_names(found, boxes, place)
    for key, box in boxes.items():
        check_form(f"{place}/{key}", found[key], box.dtype, (env.num_envs, *box.shape))
        check_box(
            f"{place}/{key}", found[key], spaces.Box(-np.inf, np.inf, box.shape) if _normalises(env) else box
        )
        if key in FLAGS:
            check_flags(f"{place}/{key}", found[key])


def check_box(place: str, values: NDArray[Any], box: spaces.Space[Any]) -> None:
    """Check that the last axes of an array are elements of a box, as far as its precision goes, and finite.

    Raises:
        CheckpointError: they are not.
    """
    if not isinstance(box, spaces.Box) or not values.size:
        return
    rows = values.reshape(-1, *box.shape)
    low, high = box.low.astype(values.dtype), box.high.astype(values.dtype)
    for start in range(0, len(rows), _CHUNK_ROWS):
        chunk = rows[start : start + _CHUNK_ROWS]
        chunk = (
            chunk.astype(np.float32) if chunk.dtype == np.float16 else chunk
        )  # numpy compares halves slowly
        for end, is_in in ((chunk.min(axis=0), np.greater_equal), (chunk.max(axis=0), np.less_equal)):
            fits = is_in(end, low if is_in is np.greater_equal else high) & np.isfinite(end)
            check_all(place, fits, end, f"{low.min()}..{high.max()}")


def check_flags(place: str, values: NDArray[Any]) -> None:
    """Check that an array holds 0 and 1 alone.

    Raises:
        CheckpointError: it does not.
    """
    check_all(place, (values == 0) | (values == 1), values, "0 or 1")


def _normalises(env: VecEnv) -> bool:
    while isinstance(env, VecEnvWrapper):
        if isinstance(env, VecNormalize):
            return True
        env = env.venv
    return False


def _monitors(env: VecEnv) -> list[VecMonitor]:
    """The env's VecMonitor, if it has one."""
    while isinstance(env, VecEnvWrapper):
        if isinstance(env, VecMonitor):
            return [env]
        env = env.venv
    return []
