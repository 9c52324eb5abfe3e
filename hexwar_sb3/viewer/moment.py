"""One moment of a game as a picture of lines and letters, which any size suits."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from hexwar_sb3.engine.picture import GROUND, check_picture_name
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.picture import centres, draw_map, draw_points, map_inches
from hexwar_sb3.pictures import CAMPS, INK, new_figure, write_figure
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.viewer.scene import SHOT_TICKS, Scene, fanned, names_of, origin_of, scenes, title_of
from hexwar_sb3.viewer.story import REFEREE

_TITLE, _WORDS, _NARROWEST = 0.6, 0.45, 7.0  # inches
_LETTERS_AN_INCH = 15  # of the words below the map
_APART = 1.25  # cells between two pieces in one cell
_KEY = "T tank, C chariot, S soldier, A aerocraft, with the vehicles or squads left"


def save_moment(replay: Replay, path: str | Path, tick: int, view: str = REFEREE) -> None:
    """Draw a game as it stood at a tick into a file (png, svg or pdf by its suffix).

    Args:
        replay: a whole one.
        path: of the file.
        tick: of the game.
        view: "referee", or a camp: then only what it knew is drawn, and no fire.

    Raises:
        ConfigError: another suffix, or a tick that the game does not have.
        UnknownNameError: another view.
    """
    check_picture_name(Path(path))
    last = int(replay.end["tick"])
    if not 0 <= tick <= last:
        raise ConfigError(f"tick {tick}; expected one of 0..{last}")
    (scene,) = scenes(replay, {tick}, view)
    write_figure(moment_picture(replay, scene, view), Path(path), origin_of(replay, view), f"tick {tick}")


def moment_picture(replay: Replay, scene: Scene, view: str = REFEREE) -> Figure:
    """The map with points, pieces and the latest fire; hollow pieces stand where they were seen last."""
    scenario = replay.scenario()
    hexmap = scenario.hexmap
    width, height = map_inches(hexmap)
    width = max(width, _NARROWEST)
    figure = new_figure(width, _TITLE + height + _WORDS)
    axes = figure.add_subplot()
    draw_map(axes, hexmap)
    axes.margins(0.01)
    axes.set_rasterization_zorder(GROUND)
    draw_points(axes, scenario, [Camp[point.owner.upper()] for point in scene.points])
    _draw_fire(axes, scene, hexmap)
    _draw_tokens(axes, scene, hexmap)
    said: Any = {"color": INK, "parse_math": False}
    figure.suptitle(f"{title_of(replay)}\n{_words(replay, scene, view)}", fontsize=11, **said)
    key = f"{_KEY}; {_marks(view)}"
    figure.supxlabel("\n".join(textwrap.wrap(key, int(width * _LETTERS_AN_INCH))), fontsize=7.5, color=INK)
    return figure


def _words(replay: Replay, scene: Scene, view: str) -> str:
    if view != REFEREE:
        return f"tick {scene.tick}, as {view} knows it; its known margin {scene.margins[view]:+d}"
    names = names_of(replay)
    margins = ", ".join(f"{names[camp]} ({camp}) {value:+d}" for camp, value in scene.margins.items())
    return f"tick {scene.tick}; margins {margins}"


def _marks(view: str) -> str:
    if view != REFEREE:
        return "hollow: where it was seen last"
    return f"lines: shots of the last {SHOT_TICKS} ticks (bold: with loss); crosses: pieces that were destroyed lately"


def _draw_fire(axes: Axes, scene: Scene, hexmap: HexMap) -> None:
    where = centres(hexmap)
    lines = LineCollection(
        [where[[shot.start, shot.end]] for shot in scene.shots],
        colors=[CAMPS[shot.camp] for shot in scene.shots],
        linewidths=[2.2 if shot.with_loss else 0.8 for shot in scene.shots],
        zorder=8,
    )
    axes.add_collection(lines)
    for death in scene.deaths:
        x, y = where[death.cell]
        axes.scatter(x, y, s=70, marker="X", fc=CAMPS[death.camp], ec="white", linewidths=0.8, zorder=8.5)


def _draw_tokens(axes: Axes, scene: Scene, hexmap: HexMap) -> None:
    where = centres(hexmap)
    for token, aside in fanned(scene.tokens):
        x, y = where[token.cell]
        colour = CAMPS[token.camp]
        fill, line = ("white", colour) if token.is_ghost else (colour, "white")
        corners = "round,pad=0.2" if token.camp == "red" else "round,pad=0.25,rounding_size=0.7"
        axes.text(
            x + _APART * aside, y, token.text, color=line, zorder=9, fontsize=7, weight="bold",
            ha="center", va="center", bbox={"boxstyle": corners, "fc": fill, "ec": line},
        )  # fmt: skip
