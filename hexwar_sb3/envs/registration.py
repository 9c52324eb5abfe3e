"""Ids of the envs, and the way to make many games of one."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium

from hexwar_sb3.errors import UnknownNameError

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor

SEEDS = 1_000_000  # that are drawn from where None is given
TASK_ENV, ROUTE_ENV, FLAT_ENV = "HexWarTask-v0", "HexWarRoute-v0", "HexWarFlat-v0"


@dataclass(frozen=True)
class EnvKind:
    """What is behind an id; modules are imported where they are used."""

    module: str  # of the VecEnv and of the env, hexwar_sb3.envs.MODULE_vec_env and ...MODULE_env
    name: str  # NameVecEnv(n_envs, settings, seed), NameEnv(**settings)
    settings: str  # module with the function `MODULE_settings`
    outcome: tuple[str, ...]  # infos of an ended episode that SB3's episode records keep

    @property
    def entry_point(self) -> str:
        """Gymnasium's."""
        return f"hexwar_sb3.envs.{self.module}_env:{self.name}Env"

    def make(self, n_envs: int, settings: dict[str, Any], seed: int) -> VecEnv:
        """Make the native VecEnv."""
        envs = import_module(f"hexwar_sb3.envs.{self.module}_vec_env")
        checked = getattr(import_module(f"hexwar_sb3.envs.{self.settings}"), f"{self.module}_settings")
        venv: VecEnv = getattr(envs, f"{self.name}VecEnv")(n_envs, checked(settings), seed)
        return venv


ENVS = {
    TASK_ENV: EnvKind("task", "Task", "settings", ("win", "margin", "points_held")),
    ROUTE_ENV: EnvKind("route", "Route", "route_settings", ("finished",)),
    FLAT_ENV: EnvKind("flat", "Flat", "flat_games", ("win", "margin", "points_held")),
}


def register_envs() -> None:
    """Tell Gymnasium the ids of our envs (once)."""
    for env_id, kind in ENVS.items():
        if env_id not in gymnasium.registry:
            gymnasium.register(env_id, entry_point=kind.entry_point)


def make_vec_env(
    env_id: str = TASK_ENV, n_envs: int = 1, seed: int | None = 0, **settings: Any
) -> VecMonitor:
    """Make the native VecEnv of an id, monitored.

    Args:
        env_id: "HexWarTask-v0", "HexWarRoute-v0" or "HexWarFlat-v0".
        n_envs: games that are stepped together.
        seed: of the episodes; episode k is the same game with any `n_envs`. None draws one.
        settings: of the env, see `TaskSettings`, `RouteSettings`.

    Raises:
        UnknownNameError: no such env, scenario, opponent or choice.
        ConfigError: a setting is out of its range.

    Example:
        >>> env = make_vec_env("HexWarTask-v0", n_envs=16, opponent=[("MA1", 2), ("MA2", 1)])
    """
    # numba and torch: only where they are needed, `import hexwar_sb3` registers without them
    from stable_baselines3.common.vec_env import VecMonitor

    if env_id not in ENVS:
        raise UnknownNameError("env", env_id, ENVS)
    if seed is None:
        seed = secrets.randbelow(SEEDS)
    kind = ENVS[env_id]
    return VecMonitor(kind.make(n_envs, settings, seed), info_keywords=kind.outcome)
