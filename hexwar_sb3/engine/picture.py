"""A picture of a whole game: paths, shots, captures and losses on the map, and the score curve."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hexwar_sb3.engine.margins import margins
from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, ReplayFileError
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.picture import centres, draw_map, draw_scenario, map_inches
from hexwar_sb3.pictures import CAMPS, INK, dress, new_figure, write_figure

PICTURES = (".png", ".svg", ".pdf")
_SHOTS = frozenset({"shot", "guided", "close_shot", "exit_shot"})
_ROUNDS = frozenset({"mortar_landed"})
_PLATE = {"boxstyle": "round,pad=0.15", "fc": "#ffffffcc", "ec": "none"}  # behind a text
_FLIGHT, _SHOT = (0, (1, 1.5)), (0, (6, 2))  # dots and dashes
GROUND = 4.9  # zorder below which the map is drawn as points, not as thousands of polygons
_SPREAD = 0.22  # cells between the paths of two pieces that walk the same way
_NAME = 40  # characters of a name
_TITLE, _LEGEND, _SCORES, _NARROWEST, _ENTRY = 0.6, 0.7, 2.0, 7.0, 1.55  # inches of the other parts


class Mark(NamedTuple):
    """Something that happened in a place."""

    camp: str
    cell: str
    tick: int


class Shot(NamedTuple):
    """One shot from cell to cell."""

    camp: str
    start: str
    cell: str
    hurt: bool  # the target lost something


@dataclass
class Story:
    """What is drawn of a game."""

    paths: dict[str, list[list[str]]] = field(default_factory=dict)  # by piece; a ride begins a new one
    shots: list[Shot] = field(default_factory=list)
    rounds: list[Mark] = field(default_factory=list)
    captures: list[Mark] = field(default_factory=list)
    deaths: list[Mark] = field(default_factory=list)


def save_game_picture(replay: Replay, path: str | Path) -> None:
    """Draw a game into a file (png, svg or pdf by its suffix).

    Raises:
        ConfigError: another suffix.
    """
    check_picture_name(Path(path))
    write_figure(game_picture(replay), Path(path), _title(replay), _origin(replay))


def check_picture_name(path: Path) -> None:
    """Check that a name ends like a picture's.

    Raises:
        ConfigError: it does not.
    """
    if path.suffix not in PICTURES:
        raise ConfigError(f"{path}: a picture's name must end in one of {', '.join(PICTURES)}")


def game_picture(replay: Replay) -> Figure:
    """The map with all that happened on it, above the margins of both camps; as wide or as high as the map is."""
    scenario, story = replay.scenario(), tell(replay)
    width, height = map_inches(scenario.hexmap)
    width = max(width, _NARROWEST)
    figure = new_figure(width, _TITLE + height + _LEGEND + _SCORES)
    ratios = [height, _LEGEND, _SCORES]
    above, between, below = figure.subplots(3, 1, height_ratios=ratios)
    draw_map(above, scenario.hexmap)
    above.margins(0.01)
    above.set_rasterization_zorder(GROUND)
    draw_scenario(above, scenario)
    _draw_paths(above, scenario.hexmap, story)
    _draw_shots(above, scenario.hexmap, story)
    _draw_marks(above, scenario.hexmap, story)
    _draw_legend(between, columns=max(2, int(width // _ENTRY)))
    _draw_scores(below, replay, story)
    figure.suptitle(f"{_title(replay)}; {_rules(replay)}", fontsize=12, color=INK, parse_math=False)
    return figure


def tell(replay: Replay) -> Story:
    """Gather paths, shots, captures and deaths from the lines of a replay."""
    if replay.camp is not None:
        found = f"the record of {replay.camp} only"
        raise ReplayFileError(replay.source, "head", found=found, expected="a whole replay")
    try:
        story = Story(paths={name: [[cell]] for name, cell, *_ in replay.states[0]["pieces"] if cell})
        for event in replay.events:
            _add_event(story, event)
    except (LookupError, TypeError) as error:  # a shot without a result, an arrival of what is not there
        found, expected = f"{type(error).__name__}: {error}", "states, and events of pieces on the map"
        raise ReplayFileError(replay.source, "events", found=found, expected=expected) from error
    return story


def _add_event(story: Story, event: Line) -> None:
    piece, kind, cell = event["piece"], event["kind"], event.get("cell", "")
    camp = piece.split(":")[0]
    mark = Mark(camp, cell, event["tick"])
    if kind == "arrived":
        story.paths[piece][-1].append(cell)
    elif kind == "off":
        story.paths[piece].append([cell])
    elif kind in _SHOTS:
        start = story.paths[event.get("shooter") or piece][-1][-1]
        story.shots.append(Shot(camp, start, cell, event["result"] > 0))
    elif kind in _ROUNDS:
        story.rounds.append(mark)
    elif kind == "occupied":
        story.captures.append(mark)
    elif kind == "dead":
        story.deaths.append(mark)


def _draw_paths(axes: Axes, hexmap: HexMap, story: Story) -> None:
    where = centres(hexmap)
    for number, (name, ways) in enumerate(story.paths.items()):
        turn = 2 * np.pi * number / max(1, len(story.paths))
        aside = _SPREAD * np.array([np.cos(turn), np.sin(turn)])
        line = _FLIGHT if "aerocraft" in name else "-"
        colour = CAMPS[name.split(":")[0]]
        for way in ways:
            x, y = (where[[hexmap.parse_cell(cell) for cell in way]] + aside).T
            axes.plot(x, y, color=colour, linewidth=1.3, linestyle=line, alpha=0.8, zorder=7)


def _draw_shots(axes: Axes, hexmap: HexMap, story: Story) -> None:
    where = centres(hexmap)
    for hurt, width, alpha in ((False, 0.4, 0.25), (True, 0.9, 0.7)):
        chosen = [shot for shot in story.shots if shot.hurt == hurt]
        ends = [[where[hexmap.parse_cell(cell)] for cell in (s.start, s.cell)] for s in chosen]
        colours = [CAMPS[shot.camp] for shot in chosen]
        lines = LineCollection(
            ends, colors=colours, linewidths=width, alpha=alpha, zorder=8, linestyles=_SHOT
        )
        axes.add_collection(lines)


def _draw_marks(axes: Axes, hexmap: HexMap, story: Story) -> None:
    where = centres(hexmap)
    shapes = ((story.rounds, "o", 70, 1.0), (story.deaths, "X", 60, 0.8), (story.captures, "P", 110, 0.8))
    for marks, shape, size, width in shapes:
        for mark in marks:
            x, y = where[hexmap.parse_cell(mark.cell)]
            hollow = shape == "o"
            face, edge = ("none", CAMPS[mark.camp]) if hollow else (CAMPS[mark.camp], "white")
            axes.scatter(x, y, s=size, marker=shape, fc=face, ec=edge, linewidths=width, zorder=9)
    for cell in sorted({mark.cell for mark in story.captures}):
        ticks = ", ".join(dict.fromkeys(f"{m.camp} {m.tick}" for m in story.captures if m.cell == cell))
        place = where[hexmap.parse_cell(cell)]
        axes.annotate(ticks, place, (8, -11), textcoords="offset points", fontsize=7, zorder=10, bbox=_PLATE)


def _draw_legend(axes: Axes, columns: int) -> None:
    ink: dict[str, Any] = {"color": INK, "linestyle": "none"}
    entries = [
        *(Line2D([], [], color=colour, label=f"{camp}: path") for camp, colour in CAMPS.items()),
        Line2D([], [], color=INK, linestyle=_FLIGHT, label="aerocraft's path"),
        Line2D([], [], color=INK, linewidth=0.9, linestyle=_SHOT, label="shot (bold: with loss)"),
        Line2D([], [], marker="P", label="capture, with its tick", **ink),
        Line2D([], [], marker="X", label="piece destroyed", **ink),
        Line2D([], [], marker="o", fillstyle="none", label="mortar round", **ink),
    ]
    starts = "starts: T tank, C chariot, S soldier (+: aboard), A aerocraft"
    axes.set_axis_off()
    axes.legend(
        handles=entries, ncols=min(columns, len(entries)), fontsize=7.5, title=starts, title_fontsize=7.5,
        loc="center", frameon=False,
    )  # fmt: skip


def _draw_scores(axes: Axes, replay: Replay, story: Story) -> None:
    end = replay.end["tick"]
    for camp, steps in margins(replay).items():
        ticks, values = zip(*steps, (end, steps[-1][1]), strict=True)
        axes.step(ticks, values, where="post", color=CAMPS[camp], linewidth=1.6, label=camp)
    for mark in story.captures:
        axes.axvline(mark.tick, color=CAMPS[mark.camp], linewidth=0.8, linestyle=":")
    axes.axhline(0, color=INK, linewidth=0.6)
    words = f"margin of each camp{'; dotted: captures' if story.captures else ''}"
    dress(axes, words, xlabel="tick", ylabel="points", xlim=(0, end or 1))
    axes.legend(loc="best", fontsize=8, framealpha=0.7)


def _title(replay: Replay) -> str:
    players, end = replay.head.get("players", {}), replay.end
    names = " against ".join(f"{players.get(c, {}).get('name', '?')[:_NAME]} ({c})" for c in CAMPS)
    results = {"red": "red wins", "blue": "blue wins", "draw": "a draw"}
    result = results.get(end["winner"], f"at tick {end['tick']}")
    final = ", ".join(f"{camp} {value:+d}" for camp, value in end["margin"].items())
    return f"{replay.head['scenario']['name'][:_NAME]}: {names}\n{result}; margin {final}"


def _origin(replay: Replay) -> str:
    """What else makes it this game and no other; for the file alone, nobody reads such a seed."""
    return f"{_rules(replay)}, seed {replay.seed}"


def _rules(replay: Replay) -> str:
    return f"rules {replay.head['rules']['version']}"
