"""Compiled kernels and plain Python play the same game, through the whole env."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SCRIPT = """
import numpy as np
from hexwar_sb3.envs.task_env import TaskEnv
env = TaskEnv(decision_ticks=150, opponent="MA2")
obs, _ = env.reset(seed=1)
for step in range(4):
    wanted = (7 * step + np.arange(len(obs["alive"]))) % obs["action_mask"].sum(-1)
    valid_first = np.argsort(1 - obs["action_mask"], axis=-1, kind="stable")
    obs, reward, *_ = env.step(np.take_along_axis(valid_first, wanted[:, None], -1)[:, 0])
    print(reward, {key: value.tobytes().hex() for key, value in obs.items()})
"""


def played(**environment: str) -> str:
    command, environment = [sys.executable, "-c", SCRIPT], {**os.environ, **environment}
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_an_episode_is_the_same_with_and_without_the_compiler() -> None:
    assert played(NUMBA_DISABLE_JIT="1") == played(NUMBA_DISABLE_JIT="0")
