"""`HexWarFlat-v0` for one game: a `gymnasium.Env`."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.envs.flat_games import FlatGames, flat_settings, flat_spaces
from hexwar_sb3.envs.registration import FLAT_ENV
from hexwar_sb3.envs.screen import METADATA, Frame, Screen


class FlatEnv(gymnasium.Env[NDArray[Any], np.int64]):
    """The paper's baseline "DQN" (Fig. 7) as an env for stock learners: the joint action as a sequence of turns.

    One step is one living piece's turn, by slot; after the last one's, Delta-t ticks are played. An action
    is task * 7 + answer: 0 stay and perform, or 1 + a direction in the camp's frame, which the piece keeps
    from cell to cell until it is illegal or the piece has its next turn. A piece whose task has no place
    that it can get to stays. An illegal action, counted in info["illegal_actions"], names no valid task and
    stands for stop, or a direction without a way from the cell and stands for staying.

    In a share of the episodes somebody may show the learner how to play; info["demo_actions"] then names its turn.

    The reward, the margin's gain by eq. (3), comes with the turn that advances time, and is 0 with the
    others; info["ticks"] is the time that was played. Only turns that advance time should discount, yet a
    stock learner has one gamma a step: for gamma a decision and N pieces give it gamma^(1/N), or 1.
    The reward is the referee's margin, so it tells of hits on enemies that the camp does not see; the observations
    tell nothing of them.

    Args:
        render_mode: "rgb_array": `render` draws what the learner's camp knows; "human": a window shows it after each
            step (needs pygame: the extra "human"); None: nothing is drawn.
        settings: fields of `TaskSettings`, but for `lower` and `privileged_state`.

    Raises:
        UnknownNameError: no such choice.
        UnknownSettingError: no such setting.
        ConfigError: a setting is out of its range, or the flat env cannot have it.

    Example:
        >>> from stable_baselines3 import DQN
        >>> env = FlatEnv(scenario="plain", opponent="MA2")
        >>> model = DQN("MlpPolicy", env, gamma=0.99 ** (1 / 7), buffer_size=20_000)
    """

    metadata: dict[str, Any] = METADATA

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode, self._screen = render_mode, Screen(render_mode, self._draw, FLAT_ENV)
        self.games = FlatGames(1, flat_settings(settings))
        self.observation_space, self.action_space = flat_spaces(self.games)
        super().reset(seed=self.games.first_seed)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Start the next episode; with a seed, the first one of that seed. A new env draws one."""
        if seed is not None:
            self.games.seed(seed)
        super().reset(seed=None if seed is None else int(seed))  # Gymnasium takes no integers of numpy
        self.games.begin(self.games.all)
        self._screen.follow()
        return self.games.observe()[0], {}

    def step(self, action: np.int64) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Play one piece's turn; the last tick is the end."""
        span = self.games.play([action])
        over = bool(span.over[0])
        info: dict[str, Any] = {"ticks": int(span.ticks[0]), "illegal_actions": int(span.illegal[0])}
        if span.demo:
            info["demo_actions"] = int(span.demo[0])
        if over:
            info |= self.games.outcome(0)
        if info["ticks"]:
            self._screen.follow()
        return self.games.observe()[0], float(span.reward[0]), over, False, info

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
        """Legal actions of the acting piece [K * 7] (sb3-contrib)."""
        return self.games.masks()[0]
