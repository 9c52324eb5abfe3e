"""The learners on a GPU, where PyTorch has one; the same tests run on the CPU."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecMonitor

import hexwar_sb3 as hx
from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX

MakeModel = Callable[..., QMIX]
STEPS = 120
KINDS: list[dict[str, Any]] = [
    {"mixer": "qmix"},
    {"mixer": "vdn"},
    {"mixer": "iql", "individual_rewards": True},
    {"mixer": "qplex"},
    {"mixer": "ow-qmix"},
    {"memory": "gru", "n_steps": 6},
    {"share_parameters": False},
    {"reward_scale": None},
]
GPU = pytest.mark.skipif(not torch.cuda.is_available(), reason="PyTorch finds no GPU on this machine")


@pytest.fixture(params=["cpu", pytest.param("cuda", marks=GPU)])
def device(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def weights(model: QMIX) -> dict[str, NDArray[Any]]:
    return {name: value.cpu().numpy().copy() for name, value in model.policy.state_dict().items()}


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_it_learns_there_and_plays_the_same_here(
    device: str, kind: dict[str, Any], make_model: MakeModel, tmp_path: Path
) -> None:
    model = make_model(device=device, **kind)
    before = weights(model)
    model.learn(STEPS)
    assert {value.device.type for value in model.policy.parameters()} == {device}
    assert any((value != before[name]).any() for name, value in weights(model).items())

    model.save(tmp_path / "model.zip")
    here = QMIX.load(tmp_path / "model.zip", device="cpu")
    obs = model.get_env().reset()  # type: ignore[union-attr]
    there, _ = model.predict(obs, deterministic=True)  # type: ignore[arg-type]
    np.testing.assert_array_equal(here.predict(obs, deterministic=True)[0], there)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_its_updates_are_those_of_the_cpu(device: str, kind: dict[str, Any], make_model: MakeModel) -> None:
    """Sums are made in another order there: what differs is small beside what was learned."""
    options = {"learning_starts": 40, "exploration_initial_eps": 1.0, "exploration_final_eps": 1.0, **kind}
    before = weights(make_model(device="cpu", **options))
    there, here = (weights(make_model(device=where, **options).learn(60)) for where in (device, "cpu"))
    for name, value in here.items():
        learned, apart = np.abs(value - before[name]).mean(), np.abs(there[name] - value).mean()
        assert apart <= 0.05 * learned, name


def test_a_checkpoint_goes_on_there(
    device: str, make_model: MakeModel, make_env: Callable[..., VecMonitor], tmp_path: Path
) -> None:
    save_checkpoint(make_model(device=device).learn(STEPS // 2), tmp_path / "checkpoint")
    resumed = load_checkpoint(tmp_path / "checkpoint", make_env(), device=device)
    resumed.learn(STEPS // 2, reset_num_timesteps=False)
    assert resumed.num_timesteps == STEPS
    assert {value.device.type for value in resumed.policy.parameters()} == {device}


def test_both_levels_learn_there(device: str, tmp_path: Path) -> None:
    env = hx.make_vec_env("HexWarTask-v0", n_envs=4, scenario="skirmish", privileged_state=True, seed=0)
    model = hx.HierarchicalQMIX("TaskPolicy", env, learning_starts=32, batch_size=16, seed=0, device=device)
    model.learn(96)
    model.save(tmp_path / "model.zip")
    frozen = model.policy.freeze()
    actions = frozen.act(env.reset())  # type: ignore[arg-type]
    there, _ = model.predict(env.reset(), deterministic=True)  # type: ignore[arg-type]
    assert actions.shape == there.shape
    assert hx.HierarchicalQMIX.load(tmp_path / "model.zip", device="cpu").device.type == "cpu"
