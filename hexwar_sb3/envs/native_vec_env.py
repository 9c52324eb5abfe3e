"""What our VecEnvs share: one object holds all games, so attributes and methods are those of the whole."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import Wrapper
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices


class NativeVecEnv(VecEnv):
    """A VecEnv whose games are stepped together in compiled code."""

    render_mode: str | None = None
    _actions: NDArray[Any] | None = None

    def step_async(self, actions: NDArray[Any]) -> None:
        """Remember the actions, a row a game."""
        self._actions = actions

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """The attribute of this env, once for each game asked for."""
        value = getattr(self, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the whole env."""
        setattr(self, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of this env once; an array over all games is handed out by rows."""
        result = getattr(self, method_name)(*method_args, **method_kwargs)
        by_game = isinstance(result, np.ndarray) and len(result) == self.num_envs
        return [result[b] if by_game else result for b in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> list[bool]:
        """No game has a wrapper of its own."""
        return [False for _ in self._get_indices(indices)]

    def close(self) -> None:
        """Nothing to release."""
