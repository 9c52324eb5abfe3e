"""A GIF of a part of a game, for chats and pages that show nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.viewer.picture import INK, RIM, draw_scene, ground, with_few_colours
from hexwar_sb3.viewer.scene import SHOT_TICKS, Scene, names_of, origin_of, scenes
from hexwar_sb3.viewer.story import CAMPS, NAME_CHARACTERS, REFEREE, VIEWS

MOST_FRAMES = 120
_WIDTH, _CAPTION, _FRAME_MS, _LAST_MS = 560, 22, 100, 2_000
_AROUND, _LEAST_CELLS = 3, 20  # cells around the pieces, and of the width of what is shown
_MOST_DOTS = 24.0  # width of a cell
_ROW = 3**0.5 / 2  # from row to row, in widths of a cell
Box = tuple[int, int, int, int]


def save_gif(
    replay: Replay, path: str | Path, start: int = 0, until: int | None = None, view: str = REFEREE
) -> None:
    """Write a part of a game as a GIF of at most MOST_FRAMES frames, whole or not at all.

    It shows the part of the map where the pieces are in that time.

    Args:
        replay: a whole one.
        path: of the file.
        start: first tick.
        until: last tick; None is the end of the game.
        view: "referee", or a camp: then only what it knew is drawn, and no fire.

    Raises:
        UnknownNameError: another view.
        ConfigError: ticks that the game does not have.
    """
    if view not in VIEWS:
        raise UnknownNameError("view", view, VIEWS)
    last = int(replay.end["tick"])
    until = last if until is None else until
    if not 0 <= start < until <= last:
        raise ConfigError(f"ticks {start} to {until}; expected two ticks of 0..{last}, the second one later")
    frames = list(_frames(replay, start, until, view))
    first = with_few_colours(frames[0])
    rest = [with_few_colours(frame, first) for frame in frames[1:]]
    times = [_FRAME_MS] * len(rest) + [_LAST_MS]
    about = origin_of(replay, view).encode("ascii", "replace")  # of a GIF's comment
    with replacing(Path(path)) as temporary:
        first.save(
            temporary, "GIF", save_all=True, append_images=rest, duration=times, loop=0, optimize=True,
            comment=about,
        )  # fmt: skip


def _frames(replay: Replay, start: int, until: int, view: str) -> Iterator[Image.Image]:
    step = -(-(until - start) // (MOST_FRAMES - 1))
    ticks = {*range(start, until, step), until}
    shown = list(scenes(replay, ticks, view, max(step, SHOT_TICKS)))
    hexmap = replay.scenario().hexmap
    left, top, right, bottom = _part(shown, hexmap)
    cell = min(_MOST_DOTS, _WIDTH / (right - left + 0.5), _WIDTH / (bottom - top) / _ROW)
    box = left * cell, top * _ROW * cell, (right + 0.5) * cell, (bottom + 1 / 3) * _ROW * cell
    map_image = ground(hexmap, cell)
    for scene in shown:
        drawn = draw_scene(map_image, scene, hexmap, cell).crop(box)
        yield _with_caption(drawn, _caption(scene, replay, view))


def _part(shown: Sequence[Scene], hexmap: HexMap) -> Box:
    """The part of the map that is shown: first column and row, and those behind the last."""
    cells = [token.cell for scene in shown for token in scene.tokens]
    if not cells:
        return 0, 0, hexmap.width, hexmap.height
    y, x = np.divmod(np.array(cells), hexmap.width)
    left, right = _span(int(x.min()), int(x.max()), _LEAST_CELLS, hexmap.width)
    top, bottom = _span(int(y.min()), int(y.max()), _LEAST_CELLS * 3 // 4, hexmap.height)
    return left, top, right, bottom


def _span(first: int, last: int, least: int, most: int) -> tuple[int, int]:
    """From where to where, with some cells around, and within the map."""
    size = min(most, max(least, last - first + 1 + 2 * _AROUND))
    start = min(max(0, (first + last + 1 - size) // 2), most - size)
    return start, start + size


def _with_caption(drawn: Image.Image, caption: str) -> Image.Image:
    image = Image.new("RGB", (_WIDTH, drawn.height + _CAPTION), RIM)
    image.paste(drawn, ((_WIDTH - drawn.width) // 2, 0))
    pen, middle = ImageDraw.Draw(image), drawn.height + _CAPTION / 2
    pen.text((6, middle), caption, INK, ImageFont.load_default(12), anchor="lm")
    return image


def _caption(scene: Scene, replay: Replay, view: str) -> str:
    names = {camp: name[: NAME_CHARACTERS // 2] for camp, name in names_of(replay).items()}
    if view != REFEREE:
        known = f"known margin {scene.margins[view]:+d}"
        return f"tick {scene.tick}: {names['red']} against {names['blue']}, as {view} knows it; {known}"
    margins = [f"{names[camp]} {scene.margins[camp]:+d}" for camp in CAMPS]
    return f"tick {scene.tick}: {', '.join(margins)}"
