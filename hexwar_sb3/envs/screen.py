"""What `render_mode` asks for: frames as arrays, or a window that follows the game (pygame, the extra "human")."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_choice
from hexwar_sb3.errors import ConfigError

Frame: TypeAlias = NDArray[np.uint8]  # [height, width, RGB]
HUMAN, ARRAY = "human", "rgb_array"
FPS = 4  # decisions a second, in a window and in a film
METADATA: dict[str, Any] = {"render_modes": [ARRAY, HUMAN], "render_fps": FPS}


class Screen:
    """Shows an env's games as its `render_mode` says.

    Args:
        mode: "rgb_array", "human", or None: nothing is drawn.
        draw: gives the frame of now.
        title: of the window.

    Raises:
        UnknownNameError: no such mode.
        ConfigError: pygame is not installed, and a window is asked for.
    """

    def __init__(self, mode: str | None, draw: Callable[[], Frame], title: str) -> None:
        if mode is not None:
            check_choice("render_mode", mode, METADATA["render_modes"])
        self.mode, self.draw, self.title = mode, draw, title
        self._pygame = _pygame() if mode == HUMAN else None
        self._window: Any = None  # pygame's, once there is something to show

    def render(self) -> Frame | None:
        """The frame, as an array; None where it goes to the window, or nothing is drawn."""
        if self.mode == ARRAY:
            return self.draw()
        self.follow()
        return None

    def follow(self) -> None:
        """Show the game of now in the window, if there is one; not faster than `FPS`."""
        if self._pygame is None:
            return
        frame = self.draw()
        if self._window is None:
            self._pygame.display.init()
            self._pygame.display.set_caption(self.title)
            self._window = self._pygame.display.set_mode((frame.shape[1], frame.shape[0]))
            self._clock = self._pygame.time.Clock()
        self._pygame.event.pump()
        self._window.blit(self._pygame.surfarray.make_surface(frame.swapaxes(0, 1)), (0, 0))
        self._pygame.display.flip()
        self._clock.tick(FPS)

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._pygame.display.quit()  # type: ignore[union-attr]
            self._window = None


def _pygame() -> Any:
    try:
        import pygame
    except ModuleNotFoundError as error:
        raise ConfigError(
            f"render_mode='human' needs pygame ({error}): pip install 'hexwar-sb3[human]'; 'rgb_array' needs nothing"
        ) from error
    return pygame
