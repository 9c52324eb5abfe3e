"""`HexWarTask-v0` for one game: a `gymnasium.Env`."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.envs.settings import task_settings
from hexwar_sb3.envs.task_games import Obs, TaskGames, action_space, observation_space


class TaskEnv(gymnasium.Env[Obs, NDArray[np.int64]]):
    """A batch of one game; the settings are those of `TaskSettings`, by keyword.

    Example:
        >>> env = TaskEnv(scenario="plain", opponent="MA2")
        >>> obs, info = env.reset(seed=0)
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  (Gymnasium declares it so)
    render_mode = None

    def __init__(self, **settings: Any) -> None:
        self.games = TaskGames(1, task_settings(settings))
        self.observation_space = cast("spaces.Space[Obs]", observation_space(self.games.sight))
        self.action_space = action_space(self.games.sight)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start the next episode; with a seed, the first one of that seed."""
        super().reset(seed=seed)
        if seed is not None:
            self.games.seed(seed)
        self.games.begin(self.games.all)
        return self._observe(), {}

    def step(self, action: NDArray[np.int64]) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        """Play one decision (Delta-t ticks) with a task index per piece; the last tick is the end."""
        span = self.games.play(np.asarray(action)[None])
        over = bool(span.over[0])
        obs = self._observe()
        info: dict[str, Any] = {"ticks": int(span.ticks[0]), "illegal_actions": int(span.illegal[0])}
        info["current_tasks"] = self.games.current_tasks({key: value[None] for key, value in obs.items()})[0]
        if over:
            info |= self.games.outcome(0)
        return obs, float(span.reward[0]), over, False, info

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid tasks, pieces one after the other [N * K] (sb3-contrib)."""
        return self.games.sight.obs["action_mask"].reshape(-1).astype(np.bool_)

    def _observe(self) -> Obs:
        return {key: value[0].copy() for key, value in self.games.look(self.games.all).items()}
