"""Ids of the envs, and the way to make many games of one."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any

import gymnasium

from hexwar_sb3.errors import UnknownNameError

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecMonitor

SEEDS = 1_000_000  # that are drawn from where None is given
TASK_ENV = "HexWarTask-v0"
_ENTRY_POINTS = {TASK_ENV: "hexwar_sb3.envs.task_env:TaskEnv"}
_OUTCOME = ("win", "margin", "points_held")  # infos of an ended game that SB3's episode records keep


def register_envs() -> None:
    """Tell Gymnasium the ids of our envs (once)."""
    for env_id, entry_point in _ENTRY_POINTS.items():
        if env_id not in gymnasium.registry:
            gymnasium.register(env_id, entry_point=entry_point)


def make_vec_env(
    env_id: str = TASK_ENV, n_envs: int = 1, seed: int | None = 0, **settings: Any
) -> VecMonitor:
    """Make the native VecEnv of an id, monitored.

    Args:
        env_id: "HexWarTask-v0".
        n_envs: games that are stepped together.
        seed: of the episodes; episode k is the same game with any `n_envs`. None draws one.
        settings: of the env, see `TaskSettings`.

    Raises:
        UnknownNameError: no such env, scenario, opponent or choice.
        ConfigError: a setting is out of its range.

    Example:
        >>> env = make_vec_env("HexWarTask-v0", n_envs=16, opponent=[("MA1", 2), ("MA2", 1)])
    """
    # numba and torch: only where they are needed, `import hexwar_sb3` registers without them
    from stable_baselines3.common.vec_env import VecMonitor

    from hexwar_sb3.envs.settings import task_settings
    from hexwar_sb3.envs.task_vec_env import TaskVecEnv

    if env_id not in _ENTRY_POINTS:
        raise UnknownNameError("env", env_id, _ENTRY_POINTS)
    if seed is None:
        seed = secrets.randbelow(SEEDS)
    return VecMonitor(TaskVecEnv(n_envs, task_settings(settings), seed), info_keywords=_OUTCOME)
