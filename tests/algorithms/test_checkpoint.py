"""A run that was broken off and resumed gives the weights of an unbroken one, to the bit."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor

from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import CheckpointError

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
    "options", [{"buffer_size": 60}, {"buffer_size": 1_000}, {"mixer": "vdn", "td_lambda": 0.8}]
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

    with pytest.raises(CheckpointError, match="found None; expected hexwar checkpoint 4"):
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
