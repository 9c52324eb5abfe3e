"""The task env under the names that PettingZoo's envs have: `parallel_env`, `env` and `raw_env`."""

from __future__ import annotations

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from hexwar_sb3.envs.parallel import parallel_env

__all__ = ["env", "parallel_env", "raw_env"]


def env(**settings: Any) -> AECEnv[str, Any, int]:
    """PettingZoo's AEC view: one agent after the other names its task, then time goes on.

    Args:
        settings: as `parallel_env` takes them.

    Example:
        >>> from hexwar_sb3.envs import hexwar_task_v0
        >>> game = hexwar_task_v0.env(camps="red", opponent="MA2")
        >>> game.reset(seed=0)
        >>> observation, reward, terminated, truncated, info = game.last()
        >>> game.step(observation["action_mask"].argmax())
        >>> game.agent_selection
        'red:tank1'
    """
    return OrderEnforcingWrapper(raw_env(**settings))


def raw_env(**settings: Any) -> AECEnv[str, Any, int]:
    """The same without a check of the order of calls."""
    return parallel_to_aec_wrapper(parallel_env(**settings))
