"""Policy distillation: several teachers into one student (III-C, Fig. 6 (c); Rusu et al. 2016)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from torch import Tensor, nn

from hexwar_sb3.algorithms.exploration import random_tasks
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.policies.task_sets import TaskSets


class Teacher(Protocol):
    """Says what it thinks of every task, and plays the best: a `FrozenPolicy`."""

    def q_values(self, obs: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Q of every task [B, N, K], in scaled points."""


@dataclass(frozen=True, slots=True)
class Page:
    """One situation of a camp, and what a teacher thinks of it; features in float16, valid rows only."""

    obs: NDArray[np.float16]  # [N, Do]
    alive: NDArray[np.float32]  # [N]
    rows: NDArray[np.int64]  # n * K + k of the valid rows
    features: NDArray[np.float16]  # [rows, Dt]
    q_values: NDArray[np.float32]  # [rows], the teacher's


@dataclass(frozen=True)
class Lesson:
    """What was met in some games, and what a teacher thinks of it."""

    pages: list[Page] = field(default_factory=list)

    def add(self, obs: Mapping[str, NDArray[Any]], q_values: NDArray[np.float32]) -> None:
        """Keep a batch of situations."""
        games, task_dim = len(q_values), obs["tasks"].shape[-1]
        valid = (obs["action_mask"] != 0).reshape(games, -1)
        features, q = obs["tasks"].reshape(games, -1, task_dim), q_values.reshape(games, -1)
        for b in range(games):
            rows = np.flatnonzero(valid[b])
            self.pages.append(
                Page(
                    obs["obs"][b].astype(np.float16),
                    obs["alive"][b].astype(np.float32),
                    rows,
                    features[b, rows].astype(np.float16),
                    q[b, rows],
                )
            )


def teach(
    teacher: Teacher, env: VecEnv, steps: int, epsilon: float, seed: int, actor: FrozenPolicy | None = None
) -> Lesson:
    """Play, and remember what a teacher thinks of all that was met.

    Args:
        teacher: its tasks are played, unless somebody else acts.
        env: a task env, whose pieces the lower level of who acts leads.
        steps: env steps of all games together.
        epsilon: probability of a random task, for each piece: the student must know what to do there, too.
        seed: of these.
        actor: who plays instead. The student itself is asked for what its teacher would do where it
            comes to by its own choices (Ross et al. 2011).
    """
    rng = np.random.default_rng(seed)
    obs: Any = env.reset()
    lesson = Lesson()
    for _ in range(-(-steps // env.num_envs)):
        values = teacher.q_values(obs)
        lesson.add(obs, values)
        tasks = values.argmax(axis=2) if actor is None else actor.act(obs)
        strays = rng.random(tasks.shape) < epsilon
        obs, _, _, _ = env.step(np.where(strays, random_tasks(obs["action_mask"] != 0, rng), tasks))
    return lesson


def masked_kl(
    student_q: Float[Tensor, " row"],
    teacher_q: Float[Tensor, " row"],
    sets: TaskSets,
    alive: Float[Tensor, " piece"],
    tau: float,
) -> Float[Tensor, ""]:
    """KL(softmax(Q_teacher / tau) || softmax(Q_student / tau)) over valid tasks, mean over living pieces.

    Rusu et al. (2016, eq. 3) leave out the student's tau; with it a student has values of its teacher's size, and can
    learn on from them.

    Args:
        student_q: its values of every valid task, in scaled points.
        teacher_q: the teacher's.
        sets: the task sets.
        alive: 1 for a living piece; the dead weigh nothing.
        tau: temperature; a small one makes choices sharp.
    """
    lowest = torch.finfo(student_q.dtype).min
    wanted = nn.functional.log_softmax(sets.spread(teacher_q / tau, lowest), dim=1)
    given = nn.functional.log_softmax(sets.spread(student_q / tau, lowest), dim=1)
    each = nn.functional.kl_div(given, wanted, reduction="none", log_target=True).sum(dim=1)
    return (each * alive).sum() / alive.sum().clamp(min=1.0)


def learn_from(
    lessons: Sequence[Lesson],
    student: TaskPolicy,
    *,
    updates: int,
    batch_size: int = 128,
    tau: float = 0.1,
    learning_rate: float = 1e-3,
    weights: Sequence[float] | None = None,
    seed: int = 0,
) -> list[float]:
    """Let a student learn its teachers' choices; the loss of every update.

    Args:
        lessons: what to learn from.
        student: its agent network learns, the mixer stays.
        updates: gradient steps; the learning rate falls to 0 over them.
        batch_size: situations of the whole camp in each.
        tau: temperature of choices, in scaled points.
        learning_rate: of Adam.
        weights: parts of the lessons in the batches; None: equal ones.
        seed: of the batches.

    Raises:
        ConfigError: nothing to learn from.
    """
    if not lessons or not all(lesson.pages for lesson in lessons):
        raise ConfigError(f"distillation needs teachers who played, got {len(lessons)} lessons")
    rng = np.random.default_rng(seed)
    shares = np.ones(len(lessons)) if weights is None else np.asarray(weights, np.float64)
    optimizer = torch.optim.Adam(student.agent.parameters(), lr=learning_rate, fused=True)
    falling = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, max(1, updates))
    losses = []
    for _ in range(updates):
        drawn = rng.choice(len(lessons), batch_size, p=shares / shares.sum())
        sets, wanted, alive = _bind(
            [lessons[k].pages[rng.integers(len(lessons[k].pages))] for k in drawn], student
        )
        loss = masked_kl(student.agent.q_values(sets), wanted, sets, alive, tau)
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(student.agent.parameters(), 10.0)
        optimizer.step()
        falling.step()
        losses.append(loss.item())
    student.settle()
    return losses


def _bind(pages: Sequence[Page], student: TaskPolicy) -> tuple[TaskSets, Tensor, Tensor]:
    """Put pages together: task sets, the teachers' values of their rows, and which pieces live."""

    def tensor(parts: Sequence[NDArray[Any]], dtype: torch.dtype = torch.float32) -> Tensor:
        return torch.as_tensor(np.concatenate(parts), device=student.device, dtype=dtype)

    n_tasks = student.shapes.n_tasks
    rows = np.concatenate([page.rows + k * student.shapes.n_pieces * n_tasks for k, page in enumerate(pages)])
    piece, task = (tensor([part], torch.int64) for part in np.divmod(rows, n_tasks))
    sets = TaskSets(
        tensor([page.obs for page in pages]), tensor([page.features for page in pages]), piece, task, n_tasks
    )
    return sets, tensor([page.q_values for page in pages]), tensor([page.alive for page in pages])
