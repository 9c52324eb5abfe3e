"""`HexWarRoute-v0` for one game: a `gymnasium.Env`."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.envs.registration import ROUTE_ENV
from hexwar_sb3.envs.route_settings import route_settings
from hexwar_sb3.envs.route_vec_env import Obs, RouteVecEnv, route_spaces
from hexwar_sb3.envs.screen import METADATA, Frame, Screen


class RouteEnv(gymnasium.Env[Obs, np.int64]):
    """A batch of one game; the settings are those of `RouteSettings`, by keyword.

    One step is one hop of the focal piece, an episode one of its routes: finished (it stays in the right
    place) is `terminated`; another task, an impossible one, the piece's loss and the end of the game are
    `truncated` (a loss costs what it costs the camp; were it an end, it would save the rest of the way). The next episode is the next piece's route in the same game, or begins a new game.
    An invalid direction stands for staying.
    The reward is the referee's margin, so it tells of hits on enemies that the camp does not see; the observations
    tell nothing of them.

    Args:
        render_mode: "rgb_array": `render` draws what the learner's camp knows; "human": a window shows it after each
            step (needs pygame: the extra "human"); None: nothing is drawn.
        settings: fields of `RouteSettings`; one scenario.

    Raises:
        UnknownNameError: no such choice.
        UnknownSettingError: no such setting.
        ConfigError: a setting is out of its range.

    Example:
        >>> env = RouteEnv(scenario="hills", upper="random")
        >>> obs, info = env.reset(seed=0)
        >>> obs["action_mask"]  # perform the task here, or go W SW SE E NE NW
        array([0, 1, 1, 1, 1, 1, 1], dtype=int8)
    """

    metadata: dict[str, Any] = METADATA

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode, self._screen = render_mode, Screen(render_mode, self._draw, ROUTE_ENV)
        self.settings = route_settings(settings)
        self.venv = RouteVecEnv(1, self.settings)
        self.observation_space, self.action_space = route_spaces()  # type: ignore[assignment]
        self._next: Obs | None = None  # first observation of the next route of this game
        super().reset(seed=self.venv.first_seed)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start the next route; with a seed, or in the middle of one, a new game. A new env draws a seed."""
        if seed is not None:
            self.venv.seed(seed)
            self._next = None
        super().reset(seed=None if seed is None else int(seed))  # Gymnasium takes no integers of numpy
        obs, self._next = self._next or _first(self.venv.reset()), None
        self._screen.follow()
        return obs, {}

    def step(self, action: np.int64) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        """Give the focal piece one answer: 0 stay and perform, or 1 + a direction in the camp's frame."""
        observed, rewards, dones, infos = self.venv.step(cast("NDArray[Any]", [action]))
        obs = cast("Obs", observed)
        info = infos[0]
        self._next = _first(obs) if dones[0] else None
        last = info.pop("terminal_observation", None) or _first(obs)
        cut = bool(info.pop("TimeLimit.truncated", False))
        self._screen.follow()
        return last, float(rewards[0]), bool(dones[0]) and not cut, cut, info

    def render(self) -> Frame | None:
        """Draw what the learner's camp knows, [height, width, RGB]; None without a render mode, or to a window."""
        return self._screen.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _draw(self) -> Frame:
        from hexwar_sb3.envs.render import draw_position  # matplotlib: only where it is asked for

        tasks = self.venv.fields[0].tasks
        return draw_position(tasks.arena, 0, int(tasks.camps[0]))

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid answers [7] (sb3-contrib)."""
        return self.venv.action_masks()[0]


def _first(obs: Obs) -> Obs:
    return {key: value[0].copy() for key, value in obs.items()}
