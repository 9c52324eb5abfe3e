"""Distillation: the loss by hand, a student that comes to choose as its teacher."""

from __future__ import annotations

from math import log
from typing import Any

import numpy as np
import pytest
import torch

from hexwar_sb3.algorithms.distillation import learn_from, masked_kl, teach
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies.task_sets import TaskSets

SETTINGS: dict[str, Any] = {"n_envs": 4, "seed": 1, "privileged_state": True}


def sets_of(rows: list[int], pieces: int) -> TaskSets:
    """Task sets with so many valid rows a piece."""
    piece = torch.tensor([i for i, n in enumerate(rows) for _ in range(n)])
    task = torch.tensor([k for n in rows for k in range(n)])
    return TaskSets(torch.zeros(pieces, 1), torch.zeros(len(piece), 1), piece, task, n_tasks=5)


def test_the_loss_by_hand() -> None:
    """KL of (3/4, 1/4) to (1/2, 1/2), and of the same to itself."""
    sets = sets_of([2, 2], 2)
    teacher = torch.tensor([log(3.0), 0.0, 1.0, 2.0]) * 0.5
    student = torch.tensor([7.0, 7.0, 1.5, 2.0])

    expected = 0.75 * log(0.75 / 0.5) + 0.25 * log(0.25 / 0.5)
    assert masked_kl(student, teacher, sets, torch.tensor([1.0, 0.0]), 0.5).item() == pytest.approx(expected)
    alone = masked_kl(student, teacher, sets, torch.tensor([0.0, 1.0]), 0.5).item()
    assert alone == pytest.approx(0.0, abs=1e-6)
    both = masked_kl(student, teacher, sets, torch.tensor([1.0, 1.0]), 0.5).item()
    assert both == pytest.approx(expected / 2)


def test_the_dead_and_the_masked_weigh_nothing() -> None:
    sets, teacher = sets_of([1, 3], 2), torch.tensor([5.0, 1.0, 0.0, 0.0])
    student = torch.tensor([0.0, 1.0, 2.0, 3.0], requires_grad=True)
    masked_kl(student, teacher, sets, torch.tensor([1.0, 0.0]), 0.1).backward()  # type: ignore[no-untyped-call]

    assert student.grad is not None
    assert torch.equal(
        student.grad, torch.zeros(4)
    )  # one valid task: nothing to choose; the other piece is dead
    assert masked_kl(student, teacher, sets, torch.zeros(2), 0.1).item() == 0.0


def test_a_sharp_teacher_is_finite() -> None:
    sets = sets_of([5, 1], 2)
    loss = masked_kl(torch.zeros(6), torch.tensor([9.0, -9.0, 3.0, 0.0, 1.0, 2.0]), sets, torch.ones(2), 1e-3)

    assert loss.item() == pytest.approx(log(5.0) / 2)


@pytest.mark.parametrize("widths", [{}, {"hidden": 96, "embed": 40}])
def test_a_student_of_any_widths_comes_to_choose_as_its_teacher(widths: dict[str, int]) -> None:
    env = make_vec_env(**SETTINGS)
    teacher = QMIX("TaskPolicy", env, seed=1, buffer_size=10).policy.freeze()
    student = QMIX("TaskPolicy", env, seed=2, buffer_size=10, policy_kwargs=widths).policy
    lesson = teach(teacher, env, steps=96, epsilon=0.2, seed=0)
    first: Any = env.reset()
    obs = {key: value.copy() for key, value in first.items()}
    before = (student.greedy(obs) == teacher.act(obs)).mean()
    losses = learn_from([lesson], student, updates=150, batch_size=32, tau=0.01, seed=0)

    assert len(lesson.pages) == 96
    assert np.mean(losses[-20:]) < 0.3 * losses[0]
    assert (student.greedy(obs) == teacher.act(obs)).mean() > max(0.8, before)
    for settled in (student.agent_target.state_dict(), student.agent_mean.state_dict()):
        assert all(torch.equal(tensor, settled[name]) for name, tensor in student.agent.state_dict().items())


def test_two_teachers_have_equal_parts() -> None:
    env = make_vec_env(**SETTINGS)
    students = [QMIX("TaskPolicy", env, seed=seed, buffer_size=10).policy for seed in (1, 2, 3)]
    lessons = [teach(one.freeze(), env, 48, 0.0, seed=0) for one in students[:2]]
    losses = learn_from(lessons, students[2], updates=3, batch_size=8, tau=0.1)
    alone = learn_from(lessons[:1], students[2], updates=1, batch_size=8, tau=0.1)

    assert len(losses) == 3
    assert len(alone) == 1


def test_the_same_seed_gives_the_same_student() -> None:
    def weights() -> torch.Tensor:
        env = make_vec_env(**SETTINGS)
        teacher = QMIX("TaskPolicy", env, seed=1, buffer_size=10).policy.freeze()
        student = QMIX("TaskPolicy", env, seed=2, buffer_size=10).policy
        learn_from([teach(teacher, env, 48, 0.1, seed=4)], student, updates=5, batch_size=8, seed=4)
        return student.agent.state_dict()["value.weight"]

    assert torch.equal(weights(), weights())


def test_a_wrong_number_is_named() -> None:
    policy = QMIX("TaskPolicy", make_vec_env(**SETTINGS), buffer_size=10).policy
    with pytest.raises(ConfigError, match="distillation needs teachers"):
        learn_from([], policy, updates=1)
