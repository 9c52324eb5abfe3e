"""A run that was broken off and resumed gives the weights of an unbroken one, to the bit."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import Env
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.play.seeds import check_rng

MakeEnv = Callable[..., VecMonitor]
MakeModel = Callable[..., QMIX]

TOTAL, BREAK = 240, 108  # env steps; the break lies within the games


class SaveAt(BaseCallback):
    """Saves at a vector-step boundary, as a run's own callback does."""

    def __init__(self, step: int, path: Path) -> None:
        super().__init__()
        self.step, self.path = step, path

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps == self.step:
            save_checkpoint(self.model, self.path)  # type: ignore[arg-type]

    def _on_step(self) -> bool:
        return True


def sha256(model: QMIX) -> str:
    digest = hashlib.sha256()
    for tensor in model.policy.state_dict().values():
        digest.update(tensor.numpy().tobytes())
    for state in model.policy.optimizer.state_dict()["state"].values():
        digest.update(state["exp_avg"].numpy().tobytes())
    return digest.hexdigest()


@pytest.mark.parametrize(
    "options",
    [
        {"buffer_size": 60},
        {"buffer_size": 1_000},
        {"mixer": "vdn", "td_lambda": 0.8},
        {"memory": "gru", "n_steps": 6, "mixer": "ow-qmix"},
        {"share_parameters": False, "memory": "gru", "n_steps": 6},
        {"individual_rewards": True, "mixer": "iql"},
    ],
)
def test_resumed_is_unbroken(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path, options: dict[str, Any]
) -> None:
    """Also with a replay that is full, so that old steps are overwritten after the break."""
    path = tmp_path / "checkpoint"
    unbroken = make_model(**options).learn(TOTAL, callback=SaveAt(BREAK, path))

    np.random.seed(99)  # noqa: NPY002  # another process has other random numbers
    torch.manual_seed(99)
    resumed = load_checkpoint(path, make_env())
    assert resumed.num_timesteps == BREAK
    resumed.learn(TOTAL - resumed.num_timesteps, reset_num_timesteps=False)

    assert resumed.num_timesteps == unbroken.num_timesteps
    assert sha256(resumed) == sha256(unbroken)
    assert resumed.env is not None
    assert resumed.env.episode_returns.tolist() == unbroken.env.episode_returns.tolist()  # type: ignore[attr-defined, union-attr]


@pytest.mark.parametrize("recalled", [np.zeros((3, 64), np.float32), np.full((12, 64), np.nan, np.float32)])
def test_a_broken_memory_is_refused(make_model: MakeModel, recalled: NDArray[np.float32]) -> None:
    model = make_model(memory="gru", n_steps=6)
    with pytest.raises(CheckpointError, match="recalled: found"):
        model.restore({"recalled": recalled})
    with pytest.raises(CheckpointError, match="recalled"):
        make_model().restore({"recalled": recalled})


def test_saving_changes_nothing(make_model: MakeModel, tmp_path: Path) -> None:
    plain = make_model().learn(TOTAL)
    saved = make_model().learn(TOTAL, callback=SaveAt(BREAK, tmp_path / "checkpoint"))

    assert sha256(plain) == sha256(saved)


def test_another_number_of_games_is_refused(make_model: MakeModel, make_env: MakeEnv, tmp_path: Path) -> None:
    save_checkpoint(make_model().learn(40), tmp_path / "checkpoint")

    with pytest.raises(CheckpointError, match="found 4 games; expected 2, as the env has"):
        load_checkpoint(tmp_path / "checkpoint", make_env(2))


def test_a_truncated_checkpoint_is_refused(make_model: MakeModel, make_env: MakeEnv, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint"
    save_checkpoint(make_model().learn(40), path)
    path.write_bytes(path.read_bytes()[:-1000])

    with pytest.raises(CheckpointError, match=r"checkpoint: .*found .*; expected .*checkpoint"):
        load_checkpoint(path, make_env())


def test_other_arrays_are_refused(make_env: MakeEnv, tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", a=np.zeros(3))

    with pytest.raises(CheckpointError, match="found None; expected hexwar checkpoint 6"):
        load_checkpoint(tmp_path / "other.npz", make_env())


def test_a_checkpoint_without_one_of_its_arrays_is_refused(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    path = tmp_path / "checkpoint.npz"
    save_checkpoint(make_model().learn(40), path)
    with np.load(path) as file:
        np.savez(path, **{name: file[name] for name in file.files if name != "replay/reward"})

    with pytest.raises(CheckpointError, match="arrays: found no 'reward'; expected all of a checkpoint"):
        load_checkpoint(path, make_env())


def ends_of(dtype: np.dtype[Any]) -> list[Any]:
    """Both ends of a type, and what is no number."""
    if dtype.kind in "iu":
        return [np.iinfo(dtype).min, np.iinfo(dtype).max]
    if dtype.kind == "f":
        return [np.finfo(dtype).min, np.finfo(dtype).max, np.nan, np.inf, -np.inf]
    return [False, True] if dtype.kind == "b" else []


def changed(name: str, array: NDArray[Any]) -> Iterator[tuple[str, NDArray[Any] | None]]:
    """The array with one thing changed, and what it is; None: without it."""
    middle = tuple(n // 2 for n in array.shape)
    for value in ends_of(array.dtype) if array.size and name != "model" else []:
        for where in (middle, ...):
            other = array.copy()
            other[where] = value
            if not np.array_equal(other, array):
                yield f"{name} = {value} at {where}", other
    yield f"{name} missing", None
    if name == "model":
        return  # its contents are the zip's business
    yield f"{name} as text", np.full(array.shape, "x")
    yield f"{name} of another type", np.zeros(array.shape, np.int16 if array.dtype != np.int16 else np.int64)
    yield f"{name} with one axis more", array[None]
    if array.ndim:
        yield f"{name} without its last row", array[:-1]
        yield f"{name} with one row more", np.concatenate([array, array[:1]])


FREE = (
    *(
        "torch_random",
        "exploring",
        "current",
        "squads/members",  # who is ordered, as "exploring" says who explores
        "replay/done",
        "replay/is_step",
        "replay/tasks",
        "replay/next_row",
    ),
    *(
        "replay/obs_obs",
        "replay/obs_state",
        "replay/obs_alive",
        "replay/discount",
        "replay/reward",
        "replay/sets",
        "replay/terminated",
    ),
)
"""What may have been otherwise: no check can know."""


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.slow)])
def test_every_array_of_a_checkpoint_is_checked(
    every: int, make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    """Each is refused in words, or goes on learning with finite weights."""
    path, broken = tmp_path / "checkpoint", tmp_path / "broken.npz"
    save_checkpoint(make_model(buffer_size=60).learn(TOTAL), path)
    with np.load(path) as file:
        arrays = dict(file)
    tried, accepted = 0, []
    for name, array in arrays.items():
        if name.startswith("env/games/"):
            continue  # the toy's own, which it takes as they are
        for what, other in changed(name, array):
            tried += 1
            if tried % every:
                continue
            np.savez(
                broken,
                **{**arrays, name: other}
                if other is not None
                else {k: v for k, v in arrays.items() if k != name},
            )
            try:
                model = load_checkpoint(broken, make_env())
            except (CheckpointError, ConfigError) as error:
                assert str(broken) in str(error) or not isinstance(error, CheckpointError), what  # noqa: PT017
                continue
            accepted.append(what)
            model.learn(24, reset_num_timesteps=False)
            assert all(torch.isfinite(tensor).all() for tensor in model.policy.state_dict().values()), what
    assert tried > 100
    assert {what.split()[0] for what in accepted} <= set(FREE), accepted


@pytest.mark.parametrize(
    ("place", "broken"),
    [
        ("random/ours", {"ours": {"bit_generator": "PCG64"}}),
        ("random/numpy", {"numpy": ["MT19937", [1] * 624, 5_000_000, 0, 0.0]}),
        ("random/numpy", {"numpy": ["MT19937", [1] * 623, 0, 0, 0.0]}),
        ("random/numpy", {"numpy": ["MT19937", [0] * 624, 0, 0, 0.0]}),
        ("random/numpy", {"numpy": ["MT19937", [2**32] * 624, 0, 0, 0.0]}),
        ("random/numpy", {"numpy": ["MT19937", [1] * 624, 0, 0, "x"]}),
        ("random/numpy", {"numpy": None}),
    ],
)
def test_a_random_state_that_is_none_is_refused(
    place: str, broken: dict[str, Any], make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    """Numpy itself takes a position behind the end of its keys, and reads there."""
    path = tmp_path / "checkpoint.npz"
    save_checkpoint(make_model().learn(40), path)
    with np.load(path) as file:
        arrays = dict(file)
    states = json.loads(str(arrays["random"]))
    np.savez(path, **{**arrays, "random": np.array(json.dumps({**states, **broken}))})

    with pytest.raises(CheckpointError, match=place):
        load_checkpoint(path, make_env())


@pytest.mark.parametrize("state", [{"inc": 2}, {"state": 2**128}, {"state": -1}, {"inc": 1.5}, {"inc": True}])
def test_the_state_of_our_generator_is_checked(state: dict[str, Any]) -> None:
    """With an even step it would draw the same number for ever."""
    whole = np.random.default_rng(0).bit_generator.state
    with pytest.raises(CheckpointError, match="snapshot: rng: found"):
        check_rng({**whole, "state": {**whole["state"], **state}}, "rng")


def test_a_checkpoint_before_the_first_step_starts_anew(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    save_checkpoint(make_model(), tmp_path / "checkpoint.npz")

    resumed = load_checkpoint(tmp_path / "checkpoint.npz", make_env()).learn(TOTAL, reset_num_timesteps=False)

    assert resumed.num_timesteps == TOTAL


def test_an_array_called_a_checkpoint_is_refused(make_env: MakeEnv, tmp_path: Path) -> None:
    np.save(tmp_path / "array.npy", np.zeros(3))
    (tmp_path / "array.npy").rename(tmp_path / "checkpoint.npz")

    with pytest.raises(CheckpointError, match=r"checkpoint\.npz: file: found .*zip.*; expected a checkpoint"):
        load_checkpoint(tmp_path / "checkpoint.npz", make_env())


def itself(env: Env[Any, Any]) -> Env[Any, Any]:
    return env


def test_running_games_need_an_env_that_can_go_on_with_them(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    save_checkpoint(make_model().learn(40), tmp_path / "checkpoint.npz")
    games: Any = make_env().venv
    plain = VecMonitor(DummyVecEnv([partial(itself, env) for env in games.envs]))

    with pytest.raises(CheckpointError, match="env/games: found running games; expected none"):
        load_checkpoint(tmp_path / "checkpoint.npz", plain)


@pytest.mark.parametrize("how", ["truncated", "array", "other", "flipped"])
def test_a_replay_that_is_none_is_refused(how: str, make_model: MakeModel, tmp_path: Path) -> None:
    path, model = tmp_path / "replay.npz", make_model().learn(40)
    model.save_replay_buffer(path)
    whole = path.read_bytes()
    with path.open("wb") as file:
        if how == "truncated":
            file.write(whole[: len(whole) // 2])
        elif how == "flipped":
            file.write(whole[:5_000] + bytes([whole[5_000] ^ 255]) + whole[5_001:])
        elif how == "array":
            np.save(file, np.zeros(3))
        else:
            np.savez(file, a=np.zeros(3))
    steps = len(model.replay_buffer)

    with pytest.raises(CheckpointError, match=r"replay\.npz: "):
        model.load_replay_buffer(path)
    assert len(model.replay_buffer) == steps


def test_a_broken_part_leaves_the_env_as_it_was(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    path, env = tmp_path / "checkpoint.npz", make_env()
    save_checkpoint(make_model().learn(40), path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **{**arrays, "last_obs/obs": np.full_like(arrays["last_obs/obs"], np.nan)})
    env.reset()
    before, returns = env.unwrapped.snapshot(), env.episode_returns.copy()  # type: ignore[attr-defined]

    with pytest.raises(CheckpointError, match="last_obs/obs: found nan"):
        load_checkpoint(path, env)

    assert all(np.array_equal(array, env.unwrapped.snapshot()[name]) for name, array in before.items())  # type: ignore[attr-defined]
    assert np.array_equal(env.episode_returns, returns)
