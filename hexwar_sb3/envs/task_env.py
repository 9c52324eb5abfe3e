"""`HexWarTask-v0` for one game: a `gymnasium.Env`."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.envs.registration import TASK_ENV
from hexwar_sb3.envs.screen import METADATA, Frame, Screen
from hexwar_sb3.envs.settings import task_settings
from hexwar_sb3.envs.task_games import Obs, TaskGames, action_space, observation_space
from hexwar_sb3.players.frozen_lower import Lower


class TaskEnv(gymnasium.Env[Obs, NDArray[np.int64]]):
    """A batch of one game; the settings are those of `TaskSettings`, by keyword.

    The reward is the referee's margin, so it tells of hits on enemies that the camp does not see; the observations
    tell nothing of them.

    Args:
        render_mode: "rgb_array": `render` draws what the learner's camp knows; "human": a window shows it after each
            step (needs pygame: the extra "human"); None: nothing is drawn.
        settings: fields of `TaskSettings`.

    Raises:
        UnknownNameError: no such choice.
        UnknownSettingError: no such setting.
        ConfigError: a setting is out of its range.

    Example:
        >>> env = TaskEnv(scenario="plain", opponent="MA2")
        >>> obs, info = env.reset(seed=0)
        >>> first_valid = obs["action_mask"].argmax(axis=-1)  # a task for each of seven pieces
        >>> obs, reward, terminated, truncated, info = env.step(first_valid)
        >>> info["ticks"]
        75
    """

    metadata: dict[str, Any] = METADATA

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode, self._screen = render_mode, Screen(render_mode, self._draw, TASK_ENV)
        self.games = TaskGames(1, task_settings(settings))
        self.observation_space = cast("spaces.Space[Obs]", observation_space(self.games.sight))
        self.action_space = action_space(self.games.sight)
        super().reset(seed=self.games.first_seed)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start the next episode; with a seed, the first one of that seed. A new env draws one."""
        if seed is not None:
            self.games.seed(seed)
        super().reset(seed=None if seed is None else int(seed))  # Gymnasium takes no integers of numpy
        self.games.begin(self.games.all)
        obs = self._observe()
        self._screen.follow()
        return obs, {}

    def step(self, action: NDArray[np.int64]) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        """Play one decision (Delta-t ticks) with a task index per piece; the last tick is the end."""
        span = self.games.play([action])
        over = bool(span.over[0])
        obs = self._observe()
        info: dict[str, Any] = {"ticks": int(span.ticks[0]), "illegal_actions": int(span.illegal[0])}
        info["current_tasks"] = self.games.current_tasks({key: value[None] for key, value in obs.items()})[0]
        if over:
            info |= self.games.outcome(0)
        self._screen.follow()
        return obs, float(span.reward[0]), over, False, info

    def render(self) -> Frame | None:
        """Draw what the learner's camp knows, [height, width, RGB]; None without a render mode, or to a window."""
        return self._screen.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _draw(self) -> Frame:
        from hexwar_sb3.envs.render import draw_position  # matplotlib: only where it is asked for

        return draw_position(self.games.arena, 0, int(self.games.camps[0]))

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid tasks, pieces one after the other [N * K] (sb3-contrib)."""
        return self.games.sight.obs["action_mask"].reshape(-1).astype(np.bool_)

    @property
    def lower_level(self) -> Lower:
        """Who leads the learner's pieces."""
        return self.games.lower

    def set_lower(self, lower: object) -> None:
        """Another lower level for the learner's pieces: "heuristic", a folder, a network, or a callable."""
        self.games.set_lower(lower)

    def set_opponent(self, opponent: object) -> None:
        """Opponents of the next episodes: a player, a list of them, or a list of (player, weight)."""
        self.games.set_opponent(opponent)

    def _observe(self) -> Obs:
        return {key: value[0].copy() for key, value in self.games.look(self.games.all).items()}
