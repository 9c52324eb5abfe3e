"""Model zips, replays of models, checkpoints: how they are loaded, and what must then be right."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.attack import valid
from tests.attack.archives import from_npy, sb3_pickle, to_npy, unzipped, with_entry
from tests.attack.load_settings import catch_trainings, command
from tests.attack.oracle import Attempt, arrays_of, check, check_alike, check_finite, learn, play
from tests.attack.tricks import Case, Lens, Trick, Tricks, byte_tricks, entry, of_file, place_cases
from tests.attack.tricks_array import npz_tricks
from tests.attack.tricks_json import HERE, VALUES, json_tricks
from tests.attack.tricks_weights import state_tricks
from tests.attack.tricks_zip import zip_tricks
from tests.attack.valid import CHECKPOINT, MODEL


def model_cases(folder: Path) -> Iterator[Case]:
    """Of the zip, its JSON, its weights; and a second file of the name without suffix."""
    for tricks in (byte_tricks, zip_tricks, data_tricks, settings_tricks, state_tricks):
        yield from of_file(MODEL, tricks, folder)
    yield from place_cases(MODEL)
    for key in ("zz", "gamma", "policy_class", "observation_space", "_logger", "replay_buffer"):
        make = partial(_set_data, key, sb3_pickle())
        yield Case("two names", f"a file model with a pickle as {key}", partial(_beside, "model", make))
        yield Case(
            "two names",
            f"a file model.zip.zip with a pickle as {key}",
            partial(_beside, "model.zip.zip", make),
        )
    yield Case("two names", "a folder model", lambda at: (at / "model").mkdir())
    yield Case("two names", "a pipe model", lambda at: os.mkfifo(at / "model"))


def _beside(name: str, make: Callable[[bytes], bytes], folder: Path) -> None:
    (folder / name).write_bytes(make((folder / MODEL).read_bytes()))


def _set_data(key: str, value: str, data: bytes) -> bytes:
    values = json.loads(unzipped(data)["data"])
    text = json.dumps({**values, key: HERE}).replace(f'"{HERE}"', value, 1)
    return with_entry("data", text.encode(), data)


def data_tricks(data: bytes) -> Tricks:
    yield from entry("data").lifted(json_tricks, data)


NAMES = (
    *("predict", "learn", "train", "save", "policy", "env", "logger", "_logger", "rng", "replay_buffer"),
    *(
        "tensorboard_log",
        "lr_schedule",
        "train_freq",
        "action_noise",
        "replay_buffer_class",
        "n_envs",
        "device",
    ),
    *("replay_buffer_kwargs", "verbose", "__class__", "__dict__", "lower", "_vec_normalize_env", "use_sde"),
    *("sde_sample_freq", "start_time", "ep_info_buffer"),
)
"""That Stable-Baselines3 sets on a model, whatever they are."""


def settings_tricks(_: bytes) -> Tricks:
    """Names that a model has, with values that it should not have."""
    elsewhere = {"a folder": '"../elsewhere/made"'}  # from where the worker works
    for name in NAMES:
        for kind in ("x", "null", "10^12", "an SB3 pickle", "list", "object", "a folder"):
            value = elsewhere.get(kind) or VALUES[kind]
            yield Trick("settings", f"{name} = {kind}", partial(_set_data, name, value))


RANGES: dict[str, tuple[float, float]] = {
    **dict.fromkeys(
        ("gamma", "tau", "exploration_rate", "exploration_initial_eps", "exploration_final_eps"), (0, 1)
    ),
    **dict.fromkeys(
        ("num_timesteps", "_n_updates", "_episode_num", "_n_calls", "learning_starts"), (0, 2**63)
    ),
    **dict.fromkeys(("upper_ticks", "lower_ticks"), (0, 2**63)),
    **dict.fromkeys(("batch_size", "buffer_size", "gradient_steps", "n_steps", "chunk_size"), (1, 10**8)),
    **dict.fromkeys(("stickiness", "takeover", "leader_agreement"), (0, 1)),
    **dict.fromkeys(("learning_rate", "reward_scale", "max_grad_norm"), (1e-320, 1.8e308)),
}
"""What may be in a model that was loaded, whatever its file says."""


def check_model(model: Any, good: Any) -> None:
    """A loaded model is one of ours in all that it has."""
    extra = set(vars(model)) ^ set(vars(good))
    check(not extra, f"it has {sorted(extra)[:3]} more, or less, than a model has")
    for name, (low, high) in RANGES.items():
        value = getattr(model, name, None)
        if value is not None:
            check(isinstance(value, int | float) and not isinstance(value, bool), f"{name} is {value!r:.40}")
            check(low <= value <= high, f"{name} is {value!r:.40}")
    for name, value in vars(good).items():
        own = getattr(model, name)
        plain = isinstance(value, bool | int | float | str) and not isinstance(own, type(value))
        check(
            not plain or (isinstance(value, float) and type(own) is int),
            f"{name} is of the type {type(own).__name__}",
        )
        check(callable(own) == callable(value), f"{name} is {own!r:.40}")
    for name in ("predict", "learn", "train", "save"):
        check(getattr(model, name).__func__ is getattr(type(model), name), f"{name} was replaced")
    check(model.tensorboard_log is None, f"it writes to {model.tensorboard_log!r:.60}")
    _check_tensors(model, good)


def _check_tensors(model: Any, good: Any) -> None:
    import torch

    state, known = model.policy.state_dict(), good.policy.state_dict()
    check(set(state) == set(known), "other layers")
    for name, tensor in state.items():
        check(
            tensor.dtype == known[name].dtype and tensor.shape == known[name].shape,
            f"{name} is {tensor.dtype}, {tuple(tensor.shape)}",
        )
        check(bool(torch.isfinite(tensor).all()), f"{name} is not finite")
    for group in model.policy.optimizer.param_groups:
        check(
            isinstance(group["lr"], float | int) and math.isfinite(group["lr"]),
            f"a learning rate of {group['lr']!r:.40}",
        )
    for values in model.policy.optimizer.state_dict()["state"].values():
        for name, tensor in values.items():
            check(
                isinstance(tensor, torch.Tensor) and bool(torch.isfinite(tensor).all()),
                f"the optimiser's {name} is not finite",
            )


def model_attempt(kind: str, root: Path) -> Attempt:
    algorithm = algorithm_of(kind)
    new_env = valid.new_routes if kind == "masked" else valid.new_games
    good = algorithm.load(root / kind / MODEL, device="cpu")
    good_here = algorithm.load(root / kind / MODEL, env=new_env(), device="cpu")

    def attempt(folder: Path) -> None:
        path = folder / ("model" if os.path.lexists(folder / "model") else MODEL)
        model = algorithm.load(path, device="cpu")
        check_model(model, good)
        env = new_env()
        model.predict(env.reset(), deterministic=True)
        model = algorithm.load(path, env=env, device="cpu")
        check_model(model, good_here)
        learn(model, 6)
        if kind == "hierarchical" and path.name == "model":
            command(
                "train",
                "-i",
                str(path),
                "--scenario",
                valid.SCENARIO,
                "-n",
                "4",
                "--runs",
                str(folder / "runs"),
            )

    catch_trainings()
    return attempt


def algorithm_of(kind: str) -> Any:
    """Class of a folder's models."""
    from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
    from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
    from hexwar_sb3.algorithms.qmix import QMIX

    return {"qmix": QMIX, "hierarchical": HierarchicalQMIX, "masked": MaskedDQN}[kind]


def npz_cases(file: str, folder: Path) -> Iterator[Case]:
    for tricks in (byte_tricks, zip_tricks, npz_tricks):
        yield from of_file(file, tricks, folder)
    yield from place_cases(file)


def steps_attempt(root: Path) -> Attempt:
    good = arrays_of(root / "steps" / "replay.npz")

    def attempt(folder: Path) -> None:
        model = valid.new_qmix()
        model._setup_learn(1, None)
        model.load_replay_buffer(folder / "replay.npz")
        check_alike(arrays_of(folder / "replay.npz"), good)
        steps = model.replay_buffer
        check(bool(((steps.tasks >= 0) & (steps.tasks < steps.n_tasks)).all()), "a task that there is not")
        check(bool(((steps.next_row >= 0) & (steps.next_row < steps.rows)).all()), "a row that there is not")
        check(bool(((steps.discount >= 0) & (steps.discount <= 1)).all()), "a discount out of range")
        for key, box in model.observation_space.spaces.items():
            if key in steps.obs:
                stored = steps.obs[key].reshape(-1, *box.shape)
                check(
                    bool(((stored >= box.low - 0.01) & (stored <= box.high + 0.01)).all()),
                    f"{key} out of its space",
                )
        model.train(1, 4)
        check_finite(model)

    return attempt


def checkpoint_cases(folder: Path) -> Iterator[Case]:
    """Of the arrays; and of the model zip in them."""
    yield from npz_cases(CHECKPOINT, folder)
    model = Lens("model", _model_in, _with_model, "model's")
    for tricks in (data_tricks, settings_tricks, state_tricks, zip_tricks):
        yield from of_file(CHECKPOINT, partial(model.lifted, tricks), folder)


def _model_in(data: bytes) -> bytes:
    return bytes(from_npy(unzipped(data)["model.npy"]).tobytes())


def _with_model(data: bytes, model: bytes) -> bytes:
    return with_entry("model.npy", to_npy(np.frombuffer(model, np.uint8)), data)


FIXED = {"games": ("n_red", "n_pieces", "n_points", "end_tick"), "pieces": ("camp", "kind", "slot", "home")}
"""What no game of a scenario changes."""


def checkpoint_attempt(kind: str, algorithm_name: str, root: Path) -> Attempt:
    from hexwar_sb3.algorithms.checkpoint import load_checkpoint

    algorithm, path = algorithm_of(algorithm_name), root / kind / CHECKPOINT
    good, good_model = arrays_of(path), load_checkpoint(path, valid.new_games(), algorithm, device="cpu")
    blood = valid.new_games().unwrapped.snapshot()["pieces"]["blood"].max()

    def attempt(folder: Path) -> None:
        env = valid.new_games()
        model = load_checkpoint(folder / CHECKPOINT, env, algorithm, device="cpu")
        check_model(model, good_model)
        found = arrays_of(folder / CHECKPOINT)
        check_alike(found, {name: array for name, array in good.items() if name != "model"})
        for part, names in FIXED.items():
            for name in names:
                same = (found[f"env/games/{part}"][name] == good[f"env/games/{part}"][name]).all()
                check(bool(same), f"{part}.{name} of another scenario was taken")
        bloods = found["env/games/pieces"]["blood"]
        check(bool(((bloods >= 0) & (bloods <= blood)).all()), "blood out of range was taken")
        play(env, model)
        model._last_obs = env.reset()
        learn(model, 6)

    return attempt
