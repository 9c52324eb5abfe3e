"""Policy distillation: several teachers into one student (III-C, Fig. 6 (c); Rusu et al. 2016)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from stable_baselines3.common.vec_env import VecEnv
from torch import Tensor, nn

from hexwar_sb3.algorithms.exploration import random_tasks
from hexwar_sb3.algorithms.replay import StepReplay
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.policies.agent import TaskNetwork
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.policies.task_sets import TaskSets


@dataclass(frozen=True)
class Lesson:
    """What a teacher met in its own games, and the teacher itself to say what it thinks of it."""

    teacher: TaskNetwork
    replay: StepReplay


def teach(
    teacher: FrozenPolicy, student: TaskPolicy, env: VecEnv, steps: int, epsilon: float, seed: int
) -> Lesson:
    """Let a teacher play, and remember what it met.

    Args:
        teacher: its tasks are played.
        student: of any widths.
        env: a task env, whose pieces the teacher's lower level leads.
        steps: env steps of all games together.
        epsilon: probability of a random task, for each piece: the student must know what to do there, too.
        seed: of these.
    """
    rng = np.random.default_rng(seed)
    replay = StepReplay(
        steps + 2 * env.num_envs, env.observation_space, env.action_space, student.device, env.num_envs
    )
    obs: Any = env.reset()
    for _ in range(-(-steps // env.num_envs)):
        before = {key: value.copy() for key, value in obs.items()}
        tasks = teacher.act(before)
        strays = rng.random(tasks.shape) < epsilon
        tasks = np.where(strays, random_tasks(before["action_mask"] != 0, rng), tasks)
        obs, reward, done, infos = env.step(tasks)
        replay.add(before, obs, tasks, reward, done, infos)
    return Lesson(student.agent_of(teacher), replay)


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
    seed: int = 0,
) -> list[float]:
    """Let a student learn its teachers' choices; the loss of every update.

    Args:
        lessons: one a teacher; each gives an equal part of every batch.
        student: its agent network learns, the mixer stays.
        updates: gradient steps; the learning rate falls to 0 over them.
        batch_size: situations of the whole camp in each.
        tau: temperature of choices, in scaled points.
        learning_rate: of Adam.
        seed: of the batches.

    Raises:
        ConfigError: no teacher, or a batch too small for all of them.
    """
    if not lessons or batch_size < len(lessons):
        raise ConfigError(
            f"distillation needs teachers, and a part of each batch for each, got {len(lessons)}, {batch_size}"
        )
    rng = np.random.default_rng(seed)
    optimizer = torch.optim.Adam(student.agent.parameters(), lr=learning_rate, fused=True)
    falling = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, max(1, updates))
    losses = []
    for _ in range(updates):
        optimizer.zero_grad()
        total = 0.0
        for lesson in lessons:
            now = lesson.replay.sample(batch_size // len(lessons), 1, rng).now
            with torch.no_grad():
                wanted = lesson.teacher.q_values(now.sets)
            loss = masked_kl(student.agent.q_values(now.sets), wanted, now.sets, now.alive.flatten(), tau)
            (loss / len(lessons)).backward()  # type: ignore[no-untyped-call]
            total += loss.item() / len(lessons)
        nn.utils.clip_grad_norm_(student.agent.parameters(), 10.0)
        optimizer.step()
        falling.step()
        losses.append(total)
    student.agent_target.load_state_dict(student.agent.state_dict())
    return losses
