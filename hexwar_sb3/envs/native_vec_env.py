"""What our VecEnvs share: one object holds all games, so attributes and methods are those of the whole."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from gymnasium import Wrapper
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from hexwar_sb3.play.arena import Arena


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

    @abstractmethod
    def seed_slots(self, seeds: Sequence[int]) -> None:
        """Give every slot the episodes of a seed of its own, from 0 on; takes effect at the next reset."""

    @abstractmethod
    def action_masks(self) -> NDArray[np.bool_]:
        """Valid actions of every game, flat [n, ...] (sb3-contrib)."""

    @abstractmethod
    def positions(self) -> Iterator[tuple[Arena, int, int]]:
        """Where each game is to be found, and whose eyes see it: arena, number in it, camp of the learner."""

    def frames(self) -> list[NDArray[np.uint8]]:
        """Draw what the learner's camp knows of every game [height, width, RGB]."""
        from hexwar_sb3.envs.render import draw_position  # matplotlib: only where it is asked for

        return [draw_position(*place) for place in self.positions()]

    def close(self) -> None:
        """Nothing to release."""
