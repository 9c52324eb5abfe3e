"""Checkpoints: everything that a run needs to go on as if it had never been broken off.

One file of arrays (`.npz`, no pickle): the model zip with networks, targets, optimiser and counters; the
replay; random states; the running games, where the env has `snapshot()` and `restore()`. It is taken at a
vector-step boundary, that is in a callback's `on_rollout_start`: SB3 calls `on_step` before the step is stored.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms.checkpoint_arrays import (
    Arrays,
    check_observation,
    env_snapshot,
    part,
    restore_env,
    under,
    write_arrays,
)
from hexwar_sb3.algorithms.exploration import NO_TASK
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.engine.fields import check_all, check_form, check_names, check_range, refuse
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.files import replacing
from hexwar_sb3.play.seeds import check_rng, text_of
from hexwar_sb3.reading import opened, parse_json, read_arrays

FORMAT = "hexwar checkpoint 6"
_SINGLE = ("format", "model", "torch_random", "random", "exploring", "current")
_GROUPS = ("replay", "last_obs", "env", "squads", "more")
_KEYS, _WORD = 624, 2**32  # of the generator behind numpy's global functions


def save_checkpoint(model: QMIX, path: str | Path) -> None:
    """Write a checkpoint, at once or not at all."""
    zipped = io.BytesIO()
    model.save(zipped)
    last_obs = cast("Arrays | None", model._last_obs)  # noqa: SLF001
    arrays = {
        "format": np.array(FORMAT),
        "model": np.frombuffer(zipped.getvalue(), np.uint8),
        "torch_random": torch.get_rng_state().numpy(),
        "random": np.array(json.dumps(_random_states(model))),
        "exploring": model.explorer.exploring,
        "current": model.current,
        **under("replay", model.replay_buffer.snapshot()),
        **under("last_obs", last_obs or {}),
        **under("env", env_snapshot(model.env) if last_obs else {}),  # before them no game has begun
        **under("squads", model.squads.snapshot()),
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
    with placed(source=path):
        return _go_on(arrays, env, algorithm, kwargs)


def _go_on(arrays: Arrays, env: VecEnv, algorithm: type[QMIX], kwargs: dict[str, Any]) -> QMIX:
    """Model and env as they were; what is broken is found before the env's games are touched."""
    torch_random, states = _checked_random(arrays)
    model = _model(arrays, env, algorithm, kwargs)
    with placed("replay"):
        model.replay_buffer.restore(part("replay", arrays))
    with placed("squads"):
        model.squads.restore(part("squads", arrays))
    with placed("more"):
        model.restore(part("more", arrays))
    games = part("env", arrays)
    if games:
        last_obs = part("last_obs", arrays)
        check_observation("last_obs", last_obs, env)
        with placed("env"):
            restore_env(env, games)
        model._last_obs = last_obs  # noqa: SLF001
        model.game_log.starting[:] = False  # what they were expected to bring at their start is not known
    torch.set_rng_state(torch_random)
    model.rng.bit_generator.state = states["ours"]
    np.random.set_state(tuple(states["numpy"]))  # noqa: NPY002
    return model


def _model(arrays: Arrays, env: VecEnv, algorithm: type[QMIX], kwargs: dict[str, Any]) -> QMIX:
    """The model, and what its pieces were about to do."""
    exploring, current, zipped = arrays["exploring"], arrays["current"], arrays["model"]
    games = len(exploring) if exploring.ndim else 0
    if games != env.num_envs:
        raise CheckpointError(
            "env", "env", found=f"{games} games", expected=f"{env.num_envs}, as the env has"
        )
    check_form("model", zipped, np.uint8, (zipped.size,))
    model = algorithm.load(io.BytesIO(zipped.tobytes()), env=env, **kwargs)
    check_form("exploring", exploring, np.bool_, model.explorer.exploring.shape)
    check_form("current", current, np.int64, model.current.shape)
    check_range("current", current, NO_TASK, model.policy.shapes.n_tasks - 1)
    model.explorer.exploring, model.current = exploring, current
    return model


def _random_states(model: QMIX) -> dict[str, Any]:
    """States of our generator and of numpy's global one, which SB3 uses."""
    name, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002
    return {
        "ours": model.rng.bit_generator.state,
        "numpy": [name, np.asarray(keys).tolist(), position, has_gauss, gauss],
    }


def _checked_random(arrays: Arrays) -> tuple[torch.Tensor, dict[str, Any]]:
    """Random states that torch and numpy can take: numpy would read on behind the end of a wrong one."""
    text, place = text_of(arrays["random"], "random"), "random"
    states = parse_json(text, "snapshot", "random states", CheckpointError, place)
    if not isinstance(states, dict):
        refuse(place, type(states).__name__, "random states")
    check_names(states, ("ours", "numpy"), place)
    check_rng(states["ours"], "random/ours")
    if not _is_global_state(states["numpy"]):
        refuse("random/numpy", "something else", "the state of numpy's global generator")
    own = torch.get_rng_state().numpy()
    check_form("torch_random", arrays["torch_random"], own.dtype, own.shape)
    state = torch.from_numpy(arrays["torch_random"])
    try:
        drawn = torch.randn(_KEYS, generator=torch.Generator().set_state(state))
    except RuntimeError as error:
        refuse("torch_random", str(error), "the state of torch's generator")
    check_all("torch_random", np.isfinite(drawn.numpy()), drawn.numpy(), "a state that numbers come from")
    return state, states


def _is_global_state(state: Any) -> bool:
    if not isinstance(state, list) or len(state) != len(np.random.get_state()):  # noqa: NPY002
        return False
    name, keys, position, has_gauss, gauss = state
    whole = all(type(number) is int for number in (position, has_gauss)) and isinstance(gauss, float | int)
    return bool(
        name == "MT19937"
        and isinstance(keys, list)
        and len(keys) == _KEYS
        and all(type(key) is int and 0 <= key < _WORD for key in keys)
        and any(keys)  # zeros alone would follow
        and whole
        and 0 <= position <= _KEYS
        and has_gauss in (0, 1)
    )


def _read(path: Path) -> Arrays:
    with opened(path, CheckpointError, "a checkpoint") as file:
        arrays = read_arrays(file, path, CheckpointError, "a checkpoint")
    name = arrays.get("format")
    found = str(name) if name is not None and name.dtype.kind == "U" and not name.ndim else None
    if found != FORMAT:
        raise CheckpointError(path, "format", found=str(found), expected=FORMAT)
    single = {name: array for name, array in arrays.items() if name.partition("/")[0] not in _GROUPS}
    with placed(source=path):
        check_names(single, _SINGLE)
    return arrays
