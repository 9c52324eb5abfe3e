"""A model that goes on from a policy stays near it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import pytest
import torch

from hexwar_sb3.algorithms.anchored import AnchoredQMIX
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.policies.agent import TaskNetwork

LEARNER: dict[str, Any] = {"learning_starts": 0, "batch_size": 16, "buffer_size": 400, "learning_rate": 1e-3}
Model = TypeVar("Model", bound=QMIX)


def new(kind: type[Model], **options: Any) -> Model:
    env = make_vec_env("HexWarTask-v0", n_envs=2, opponent="MA1", privileged_state=True, seed=0)
    return kind("TaskPolicy", env, seed=0, **LEARNER, **options)


@pytest.fixture(scope="module")
def policy() -> FrozenPolicy:
    return new(QMIX).policy.freeze()


def kept(model: QMIX, policy: FrozenPolicy) -> float:
    """Share of choices that are still the policy's after twenty updates."""
    model.take_over(policy)
    model.learn(10 * 24 * 2)
    env = make_vec_env("HexWarTask-v0", n_envs=8, opponent="MA1", seed=1)
    obs: Any = env.reset()
    same = []
    for _ in range(12):
        tasks = policy.act(obs)
        same.append((model.policy.greedy(obs) == tasks)[obs["alive"] > 0])
        obs, _, _, _ = env.step(tasks)
    return float(np.concatenate(same).mean())


def test_the_anchor_holds_what_learning_alone_undoes(policy: FrozenPolicy) -> None:
    """A beginner's values are close together: a low temperature tells them apart."""
    free = kept(new(QMIX), policy)
    held = kept(new(AnchoredQMIX, anchor_weight=1.0, anchor_tau=0.003), policy)

    assert free < 0.5
    assert held > 0.75


def test_without_weight_it_learns_as_qmix_does(policy: FrozenPolicy) -> None:
    models: tuple[QMIX, ...] = new(QMIX), new(AnchoredQMIX, anchor_weight=0.0)
    for model in models:
        model.take_over(policy)
        model.learn(4 * 24 * 2)

    assert models[0].policy.freeze().sha256 == models[1].policy.freeze().sha256


def test_the_anchor_itself_does_not_learn(policy: FrozenPolicy) -> None:
    model = new(AnchoredQMIX)
    model.take_over(policy)
    anchor = cast("TaskNetwork", model.anchor)
    before = {name: tensor.clone() for name, tensor in anchor.state_dict().items()}
    model.learn(4 * 24 * 2)

    assert all(torch.equal(tensor, before[name]) for name, tensor in anchor.state_dict().items())
    assert model.policy.freeze().sha256 != policy.sha256


def test_a_loaded_model_has_its_settings_and_no_anchor(policy: FrozenPolicy, tmp_path: Path) -> None:
    model = new(AnchoredQMIX, anchor_weight=0.3)
    model.take_over(policy)
    model.save(tmp_path / "model.zip")
    loaded = AnchoredQMIX.load(tmp_path / "model.zip")

    assert (loaded.anchor_weight, loaded.anchor_tau, loaded.anchor) == (0.3, 0.1, None)
    assert loaded.policy.freeze().sha256 == policy.sha256
    loaded.take_over(policy)
    assert loaded.anchor is not None


@pytest.mark.parametrize(
    "options",
    [{"anchor_weight": -1.0}, {"anchor_tau": 0.0}, {"anchor_weight": float("nan")}, {"anchor_tau": "x"}],
)
def test_a_wrong_number_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match=r"anchor_(weight|tau) must be .*, got"):
        new(AnchoredQMIX, **options)
