"""What the jobs of a league share: settings of the env, seeds, one thread."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import SEEDS_PER_PURPOSE

Opponents = Sequence[tuple[object, float]]  # player, weight


def env_settings(terms: Terms, n_envs: int) -> dict[str, Any]:
    """Settings of the task env for games on these terms."""
    return {
        "scenario": terms.scenario,
        "decision_ticks": terms.decision_ticks,
        "spots": terms.spots,
        "decisions": "event" if terms.early else "fixed",
        "reward": "net",
        "n_envs": n_envs,
        "privileged_state": True,
    }


def env_steps(env: Mapping[str, Any], games: int) -> int:
    """Env steps that make so many games."""
    return games * load_world(env["scenario"]).scenario.game_ticks // int(env["decision_ticks"])


def job_seed(*numbers: int) -> int:
    """Seed in 0..999999 for a job, from the numbers that name it."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0]) % SEEDS_PER_PURPOSE


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread: as fast as two here, and jobs run side by side."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
