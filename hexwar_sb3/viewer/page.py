"""One HTML file that shows a game: the built page, with the map and the stories as packed blocks.

It needs no network and no server: code, style and data are in it, and its policy forbids the rest. Equal input gives equal bytes.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.files import replacing
from hexwar_sb3.viewer.map_block import map_block, map_key
from hexwar_sb3.viewer.picture import picture_of
from hexwar_sb3.viewer.story import CAMPS, REFEREE, VIEWS, Teller
from hexwar_sb3.viewer.tracks import Json

ALL = "all"
CHOICES = (ALL, *VIEWS)
MAX_PAGE_BYTES = 20_000_000  # beyond it a browser is slow to open a file
TITLE, PICTURE, DATA = "<!--title-->", "<!--picture-->", "<!--data-->"  # where the built page has room


def replay_page(replay: Replay, view: str = ALL) -> str:
    """The page of a game.

    Args:
        replay: a whole one.
        view: "all", "referee", or a camp: then nothing is in the page that the camp does not know.

    Raises:
        UnknownNameError: another view.
        ReplayFileError: the replay cannot be played again.

    Example:
        >>> page = replay_page(Replay.of(Game("plain", seed=0)), "red")
        >>> page.count("<script")  # the map, red's story and the code
        3
    """
    return page_and_picture(replay, view)[0]


def page_and_picture(replay: Replay, view: str) -> tuple[str, bytes]:
    """The page of a game, and the PNG in it; the game is played again once."""
    if view not in CHOICES:
        raise UnknownNameError("view", view, CHOICES)
    teller = Teller(replay)
    told = teller.stories(VIEWS if view == ALL else (view,))
    hexmap = teller.game.world.scenario.hexmap
    blocks = {f"map-{map_key(hexmap)}": map_block(hexmap)}
    blocks |= {f"story-1-{name}": story for name, story in told.items()}
    picture = picture_of(teller.game, view if view in CAMPS else None)
    data = {name: packed(block) for name, block in blocks.items()}
    return filled(_title(told[next(iter(told))], view), data, picture), picture


def save_page(replay: Replay, path: str | Path, view: str = ALL) -> None:
    """Write the page of a game, whole or not at all.

    Raises:
        ConfigError: the page is larger than a browser opens well.
    """
    page = replay_page(replay, view).encode()
    if len(page) > MAX_PAGE_BYTES:
        raise ConfigError(f"{path}: the page has {len(page)} bytes; at most {MAX_PAGE_BYTES}")
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(page)


def filled(title: str, blocks: Mapping[str, str], picture: bytes) -> str:
    """The built page with a title, packed data blocks and the picture for browsers that cannot show the rest."""
    data = "".join(tagged(name, block) for name, block in blocks.items()).rstrip()
    source = f"data:image/png;base64,{base64.b64encode(picture).decode()}"
    image = f'<img src="{source}" alt="{html.escape(title)}: how it ended">' if picture else ""
    page = _built()
    for place, text in ((TITLE, html.escape(title)), (PICTURE, image), (DATA, data)):
        page = page.replace(place, text)
    return page


@lru_cache(maxsize=1)
def _built() -> str:
    return (files("hexwar_sb3.viewer") / "built" / "page.html").read_text(encoding="utf-8")


def tagged(name: str, block: str) -> str:
    """A packed block as a line of a page."""
    return f'<script type="text/plain" id="{name}">{block}</script>\n'


def packed(block: Any) -> str:
    """A block of data: JSON without blanks, gzip, base64."""
    text = json.dumps(block, separators=(",", ":"), ensure_ascii=False).encode()
    return base64.b64encode(gzip.compress(text, compresslevel=9, mtime=0)).decode()


def _title(story: Json, view: str) -> str:
    names = " against ".join(story["players"][camp]["name"] for camp in ("red", "blue"))
    seen = "" if view in (ALL, REFEREE) else f", seen by {view}"
    return f"{names}, {story['scenario']}{seen}"
