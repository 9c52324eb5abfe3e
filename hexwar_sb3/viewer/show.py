"""A game to watch in a notebook."""

from __future__ import annotations

import base64
import html
from typing import Any

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.viewer.page import ALL, page_and_picture

HEIGHT = 680  # of the frame in a notebook, CSS pixels


class Shown:
    """A page, and a picture of how the game ended for places that show no pages."""

    def __init__(self, page: str, picture: bytes) -> None:
        self.page, self.picture = page, picture

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """What a notebook shows: the page in a frame of its own, which may run its script and nothing else."""
        inside = html.escape(self.page, quote=True)
        frame = (
            f'<iframe sandbox="allow-scripts" srcdoc="{inside}" title="A recorded game" width="100%"'
            f' height="{HEIGHT}" style="border: 0" loading="lazy"></iframe>'
        )
        return {"text/html": frame, "image/png": base64.b64encode(self.picture).decode()}

    def __repr__(self) -> str:
        return f"<a page of {len(self.page)} characters; it shows itself in a notebook>"


def show(replay: Replay, view: str = ALL) -> Shown:
    """A game to watch in a notebook; `hexwar watch FILE -o game.html` writes the same page as a file.

    It is a function and no method of `Replay`, because a replay is of the engine, which knows nothing of pages.

    Args:
        replay: a whole one.
        view: "all", "referee", "red" or "blue"; of a camp nothing is in the page that it did not know.

    Example:
        >>> game = Game("plain", seed=0)
        >>> show(Replay.of(game), "red")
        <a page of ... characters; it shows itself in a notebook>
    """
    return Shown(*page_and_picture(replay, view))
