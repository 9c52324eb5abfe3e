"""What the jobs of a league share: how a learner begins, settings of the env, seeds, one thread."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.evaluation.seeds import SEEDS_PER_PURPOSE, Purpose, seed_for
from hexwar_sb3.league.member import Member, read_networks
from hexwar_sb3.players.terms import USUAL, Terms

Opponents = Sequence[tuple[object, float]]  # player, weight


@dataclass(frozen=True, kw_only=True)
class Training:
    """What every training of a league depends on, and the folder that it leaves."""

    seed: tuple[int, ...]  # numbers that name it
    folder: Path  # gets the policies
    env: Mapping[str, Any]  # settings of the task env
    games: int  # that each model learns from
    fill_games: int  # before them, from which nothing learns
    refit_games: int  # and in which the mixer alone learns
    learner: Mapping[str, Any]  # arguments of QMIX
    about: Mapping[str, str]  # texts for the policies' folders


def begin(member: Member, env: Mapping[str, Any], learner: Mapping[str, Any], seed: int) -> QMIX:
    """Make a learner that goes on where a member left off; its optimiser and its replay are new.

    Args:
        member: with its networks, or the policy alone: then the mixer is new, and a narrower network is widened.
        env: settings of the task env.
        learner: arguments of QMIX.
        seed: of learner and games, in 0..999999.

    Raises:
        PolicyFileError: the policy's folder is broken.
        CheckpointError: its networks are, or they are others than this learner's.
    """
    policy = member.policy()
    games = make_vec_env(TASK_ENV, seed=seed_for(Purpose.TRAINING, seed), **{**env, "lower": policy.lower})
    model = QMIX("TaskPolicy", games, seed=seed, **learner)
    if member.networks.is_file():
        read_networks(member, model.policy)
        model.lead_with(policy.lower)
    else:
        model.take_over(policy)
    return model


def go_on(model: QMIX, spec: Training) -> None:
    """Let a model learn on: a replay of a few games and a mixer that does not know them would spoil what it can."""
    for let, games in ((model.fill_replay, spec.fill_games), (model.refit_mixer, spec.refit_games)):
        let(env_steps(spec.env, games))
    model.learn(env_steps(spec.env, spec.games))


def env_settings(terms: Terms, n_envs: int) -> dict[str, Any]:
    """Settings of the task env for games on these terms."""
    return {**terms.settings, "reward": "net", "n_envs": n_envs, "privileged_state": True}


def env_steps(env: Mapping[str, Any], games: int) -> int:
    """Env steps that make so many games."""
    return Terms(**{name: env[name] for name in USUAL.settings}).env_steps(games)


def job_seed(*numbers: int) -> int:
    """Seed in 0..999999 for a job, from the numbers that name it."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0]) % SEEDS_PER_PURPOSE


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread: results have the same bits everywhere, and jobs run side by side."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
