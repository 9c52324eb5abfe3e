"""Distillation as a callback: first the teachers, then the mixer, then all of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback

from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.distillation import DistillationCallback
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.players.frozen_lower import FrozenLower, fastest_way_network
from hexwar_sb3.policies.task_policy import TaskPolicy

SHORT = Lessons(games=4, updates=60, batch_size=16, tau=0.02)
SMALL: dict[str, Any] = {"learning_starts": 0, "buffer_size": 400, "batch_size": 8}


def qmix(seed: int) -> QMIX:
    return QMIX("TaskPolicy", make_vec_env(n_envs=2, seed=1, privileged_state=True), seed=seed, **SMALL)


def flat(part: torch.nn.Module) -> torch.Tensor:
    return torch.cat([parameter.detach().flatten() for parameter in part.parameters()])


class Weights(EverySteps):
    """What the agent network and the mixer were every 48 env steps."""

    def fire(self) -> None:
        self.seen = getattr(self, "seen", [])
        policy = cast("TaskPolicy", self.model.policy)
        self.seen.append([flat(policy.agent), flat(policy.mixer)])


def test_the_model_learns_its_teachers_choices_then_its_mixer_then_on(tmp_path: Path) -> None:
    teacher = qmix(1).policy.freeze()
    teacher.save(tmp_path)
    model, callback, weights = qmix(2), DistillationCallback([tmp_path], SHORT, refit_games=4), Weights(48)
    model.learn(48 * 4, callback=[callback, weights])

    assert sum(callback.losses[-10:]) < 0.5 * sum(callback.losses[:10])
    agents, mixers = ([pair[k] for pair in weights.seen] for k in (0, 1))
    assert torch.equal(agents[0], agents[1])  # the first four games, two at a time
    assert not torch.equal(mixers[0], mixers[1])
    assert not torch.equal(agents[-2], agents[-1])


class Stop(BaseCallback):
    """Ctrl-C at the first step."""

    def _on_step(self) -> bool:
        raise KeyboardInterrupt


def test_a_training_after_one_that_was_interrupted_learns_with_all_of_it() -> None:
    model = qmix(2)
    with pytest.raises(KeyboardInterrupt):
        model.learn(
            48, callback=[DistillationCallback([qmix(1).policy.freeze()], SHORT, refit_games=4), Stop()]
        )
    before = flat(model.policy.agent)
    model.learn(48, reset_num_timesteps=False)

    assert not torch.equal(before, flat(model.policy.agent))


@dataclass
class Waiting:
    """An opponent that is a dataclass."""

    task: int

    def act(self, obs: dict[str, Any]) -> Any:
        return np.full(obs["action_mask"].shape[:2], self.task)


def test_opponents_of_the_env_may_be_any_objects() -> None:
    env = make_vec_env(n_envs=2, seed=1, privileged_state=True, opponent=Waiting(0))
    model = QMIX("TaskPolicy", env, seed=2, **SMALL)
    callback = DistillationCallback([qmix(1).policy.freeze()], Lessons(games=2, updates=2), refit_games=0)
    model.learn(2, callback=callback)

    assert len(callback.losses) == 2


def test_both_levels_of_a_student_are_its_teachers(tmp_path: Path) -> None:
    teacher = qmix(1).policy.freeze().led_by(fastest_way_network())
    model = HierarchicalQMIX("HierarchicalPolicy", qmix(2).env, phase_ticks=(1, 0), seed=2, **SMALL)
    model.learn(48, callback=DistillationCallback([teacher], SHORT, refit_games=1))
    model.save(tmp_path / "model")

    assert isinstance(HierarchicalQMIX.load(tmp_path / "model").policy.lower, FrozenLower)
    assert model.env is not None
    assert model.env.get_attr("lower_level")[0] is teacher.lower


def test_a_student_is_a_model_of_ours() -> None:
    ppo = MaskablePPO("MultiInputPolicy", make_vec_env(n_envs=2, seed=0), n_steps=24, batch_size=16)
    with pytest.raises(ConfigError, match="the student is a QMIX or HierarchicalQMIX, got MaskablePPO"):
        ppo.learn(1, callback=DistillationCallback([qmix(1).policy.freeze()], SHORT))


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no games": ({"games": 0}, "games must be an integer >= 1"),
    "a share": ({"epsilon": 1.5}, r"epsilon must be in 0\.\.1"),
    "no temperature": ({"tau": 0.0}, "tau must be"),
    "not a number": ({"learning_rate": float("nan")}, "learning_rate must be"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_number_is_named(what: str) -> None:
    settings, message = WRONG[what]
    with pytest.raises(ConfigError, match=message):
        Lessons(**settings)


def test_somebody_must_teach() -> None:
    with pytest.raises(ConfigError, match="at least one teacher"):
        qmix(1).learn(1, callback=DistillationCallback([], SHORT))
