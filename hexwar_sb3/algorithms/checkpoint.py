"""Checkpoints: everything that a run needs to go on as if it had never been broken off.

One file of arrays (`.npz`, no pickle): the model zip with networks, targets, optimiser and counters; the
replay; random states; the running games, where the env has `snapshot()` and `restore()`. It is taken at a
vector-step boundary, that is in a callback's `on_rollout_start`: SB3 calls `on_step` before the step is stored.
"""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms.parts import Arrays, env_snapshot, part, restore_env, under, write_arrays
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.files import replacing

FORMAT = "hexwar checkpoint 3"


def save_checkpoint(model: QMIX, path: str | Path) -> None:
    """Write a checkpoint, at once or not at all."""
    zipped = io.BytesIO()
    model.save(zipped)
    arrays = {
        "format": np.array(FORMAT),
        "model": np.frombuffer(zipped.getvalue(), np.uint8),
        "torch_random": torch.get_rng_state().numpy(),
        "random": np.array(json.dumps(_random_states(model))),
        "exploring": model.explorer.exploring,
        "current": model.current,
        **under("replay", model.replay_buffer.snapshot()),
        **under("last_obs", cast("Arrays", model._last_obs or {})),  # noqa: SLF001
        **under("env", env_snapshot(model.env)),
        **under("more", model.snapshot()),
    }
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        write_arrays(file, arrays)


def load_checkpoint(path: str | Path, env: VecEnv, algorithm: type[QMIX] = QMIX, **kwargs: Any) -> QMIX:
    """Read a checkpoint, and put the env where it was.

    Go on with `model.learn(total - model.num_timesteps, reset_num_timesteps=False)`: on a CPU the weights are
    those of an unbroken run, if the env has `snapshot()` and `restore()`; else its games start anew.

    Args:
        path: of the checkpoint.
        env: like the one that the run had, with as many games.
        algorithm: class of the model.
        kwargs: further arguments of `algorithm.load`.

    Raises:
        CheckpointError: it is broken, not a checkpoint, or of another number of games.
        ConfigError: its sizes are not the env's, or its games are of another scenario, other rules or bots.
    """
    arrays = _read(Path(path))
    try:
        return _go_on(arrays, path, env, algorithm, kwargs)
    except KeyError as error:
        raise CheckpointError(path, "arrays", found=f"no {error}", expected="all of a checkpoint") from error


def _go_on(
    arrays: Arrays, path: str | Path, env: VecEnv, algorithm: type[QMIX], kwargs: dict[str, Any]
) -> QMIX:
    """Model and env as they were; KeyError if an array is missing."""
    if len(arrays["exploring"]) != env.num_envs:
        found = f"{len(arrays['exploring'])} games"
        raise CheckpointError(path, "env", found=found, expected=f"{env.num_envs}, as the env has")
    model = algorithm.load(io.BytesIO(arrays["model"].tobytes()), env=env, **kwargs)
    model.replay_buffer.restore(part("replay", arrays))
    model.explorer.exploring, model.current = arrays["exploring"], arrays["current"]
    games = part("env", arrays)
    if games:
        restore_env(env, games)
        model._last_obs = part("last_obs", arrays)  # noqa: SLF001
        model.game_log.starting[:] = False  # what they were expected to bring at their start is not known
    model.restore(part("more", arrays))
    torch.set_rng_state(torch.from_numpy(arrays["torch_random"]))
    _set_random_states(model, json.loads(str(arrays["random"])))
    return model


def _random_states(model: QMIX) -> dict[str, Any]:
    """States of our generator and of numpy's global one, which SB3 uses."""
    name, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002
    return {
        "ours": model.rng.bit_generator.state,
        "numpy": [name, np.asarray(keys).tolist(), position, has_gauss, gauss],
    }


def _set_random_states(model: QMIX, states: dict[str, Any]) -> None:
    model.rng.bit_generator.state = states["ours"]
    np.random.set_state(tuple(states["numpy"]))  # noqa: NPY002


def _read(path: Path) -> Arrays:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise CheckpointError(path, "file", found=str(error), expected="a checkpoint") from error
    if str(arrays.get("format")) != FORMAT:
        raise CheckpointError(path, "format", found=str(arrays.get("format")), expected=FORMAT)
    return arrays
