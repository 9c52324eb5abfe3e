"""Cooperative games of other libraries by their names."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import gymnasium

from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.errors import ConfigError, shortened

NAMES = (
    "a Gymnasium id, with its module where that is to be imported first (lbforaging:Foraging-8x8-2p-2f-coop-v3), or the"
    " module of a PettingZoo env (mpe2.simple_spread_v3)"
)


def make_joint(name: str, env_kwargs: Mapping[str, Any] | None = None, **joint: Any) -> JointActionEnv:
    """Make a cooperative game by its name, for `QMIX`.

    Args:
        name: a Gymnasium id, "MODULE:ID" where the module registers it, or a module with `parallel_env` or `env`.
        env_kwargs: arguments of the game.
        joint: arguments of `JointActionEnv`.

    Raises:
        ConfigError: there is no such game, it does not take these arguments, or it is no cooperative one.
    """
    is_id = ":" in name or name in gymnasium.registry
    try:
        if is_id:
            game: Any = gymnasium.make(name, disable_env_checker=True, **dict(env_kwargs or {}))
        else:
            module = import_module(name)
            make = getattr(module, "parallel_env", None) or getattr(module, "env", None)
            if make is None:
                raise ConfigError(f"{name} has neither parallel_env nor env; an env is {NAMES}")
            game = make(**dict(env_kwargs or {}))
    except ModuleNotFoundError as error:
        raise ConfigError(f"there is no env {shortened(name)!r} ({error}); an env is {NAMES}") from error
    except (gymnasium.error.Error, TypeError) as error:
        raise ConfigError(f"env {shortened(name)!r}: {shortened(str(error))}") from error
    return JointActionEnv(game, **joint)
