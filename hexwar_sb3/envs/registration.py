"""Ids of the envs, and the way to make many games of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium

from hexwar_sb3.errors import ConfigError, UnknownNameError

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor

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

    @property
    def vector_entry_point(self) -> str:
        """Gymnasium's, of many games in one call."""
        return f"hexwar_sb3.envs.vector_env:{self.name}VectorEnv"

    def make(self, n_envs: int, settings: dict[str, Any], seed: int | None) -> VecEnv:
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
            gymnasium.register(
                env_id, entry_point=kind.entry_point, vector_entry_point=kind.vector_entry_point
            )


def make_vec_env(
    env_id: str = TASK_ENV,
    n_envs: int = 1,
    seed: int | None = None,
    *,
    env_kwargs: Mapping[str, Any] | None = None,
    **settings: Any,
) -> VecMonitor:
    """Make the native VecEnv of an id, monitored.

    Rewards are gains of the referee's margin, so they tell of hits on enemies that the camp does not see.

    Args:
        env_id: "HexWarTask-v0", "HexWarRoute-v0" or "HexWarFlat-v0".
        n_envs: games that are stepped together.
        seed: of the episodes; episode k of a seed is the same game with any `n_envs`. None draws one.
        env_kwargs: settings of the env in one dict, as SB3's own `make_vec_env` takes them.
        settings: of the env, see `TaskSettings`, `RouteSettings`.

    Raises:
        UnknownNameError: no such env, scenario, opponent or choice.
        UnknownSettingError: no such setting.
        ConfigError: a setting is out of its range or said twice, or a player does not fit the scenario.

    Example:
        >>> env = make_vec_env("HexWarTask-v0", n_envs=16, opponent=[("MA1", 2), ("MA2", 1)])
        >>> env.reset()["action_mask"].shape  # games, pieces, tasks
        (16, 7, 40)
    """
    # numba and torch: only where they are needed, `import hexwar_sb3` registers without them
    from stable_baselines3.common.vec_env import VecMonitor

    if str(env_id) not in ENVS:
        raise UnknownNameError("env", str(env_id), ENVS)
    if twice := sorted(settings.keys() & (env_kwargs or {}).keys()):
        raise ConfigError(f"{', '.join(twice)}: said by env_kwargs and by keyword; leave one out")
    kind, settings = ENVS[env_id], {**(env_kwargs or {}), **settings}
    return VecMonitor(kind.make(n_envs, settings, seed), info_keywords=kind.outcome)
