"""`HexWarTask-v0` for many games at once: a native VecEnv of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import Wrapper
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from hexwar_sb3.envs.settings import TaskSettings, check_share
from hexwar_sb3.envs.task_games import Obs, Span, TaskGames, action_space, observation_space
from hexwar_sb3.play.arena import Snapshot


class TaskVecEnv(VecEnv):
    """All games are stepped in one call; ended ones start anew.

    The arrays of an observation are reused by the step after the next: copy what must stay.

    Args:
        n_envs: games.
        settings: the env's settings.
        seed: of the episodes.
    """

    render_mode: str | None = None

    def __init__(self, n_envs: int, settings: TaskSettings, seed: int = 0) -> None:
        self.games = TaskGames(n_envs, settings, seed)
        self._actions: NDArray[Any] | None = None
        sight = self.games.sight
        super().__init__(n_envs, observation_space(sight), action_space(sight))

    def reset(self) -> Obs:
        """Start the next episode in every slot."""
        self.games.begin(self.games.all)
        return self.games.look(self.games.all)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Remember the actions, task indices [n, N]."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Play one decision of every game."""
        span = self.games.play(np.asarray(self._actions))
        self.games.turn()
        obs = self.games.look(self.games.all)
        current = self.games.current_tasks(obs)
        infos = [self._info(b, span, obs) | {"current_tasks": current[b]} for b in range(self.num_envs)]
        ended = self.games.all[span.over]
        if ended.size:
            self.games.begin(ended)
            self.games.look(ended)
        return obs, span.reward, span.over, infos

    def _info(self, b: int, span: Span, obs: Obs) -> dict[str, Any]:
        info: dict[str, Any] = {"ticks": int(span.ticks[b]), "illegal_actions": int(span.illegal[b])}
        if b in span.demo:
            info["demo_actions"] = span.demo[b]
        if span.over[b]:
            info |= self.games.outcome(b)
            info["terminal_observation"] = {key: value[b].copy() for key, value in obs.items()}
            info["TimeLimit.truncated"] = False
        return info

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid tasks of every game, pieces one after the other [n, N * K] (sb3-contrib)."""
        return self.games.sight.obs["action_mask"].reshape(self.num_envs, -1).astype(np.bool_)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Count episodes from 0 again under this seed; takes effect at the next reset."""
        if seed is not None:
            self.games.seed(seed)
        return [seed] * self.num_envs

    def set_demo_share(self, share: float) -> None:
        """Share of the episodes, from the next ones on, in which the demo bot plays the learner's seat."""
        self.games.demo_share = check_share("demo_share", share)

    def set_warm_start(self, share: float) -> None:
        """Share of the episodes, from the next ones on, that begin near the hot spots."""
        self.games.warm_start = check_share("warm_start", share)

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays that `np.savez` takes."""
        return self.games.snapshot()

    def restore(self, snapshot: Snapshot) -> Obs:
        """Go on where `snapshot` was taken, in an env of the same settings; the observation there."""
        return self.games.restore(snapshot)

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
