"""One table of features: name, width, scale, source. Widths and the docs' index come from it.

`observe.py` writes them in this order; every number is multiplied by its scale. Everything is in
the camp's frame: for blue, cells are mirrored and directions run by the mirrored table.
Counts of pieces and points are the scenario's, so `sizes` needs them. Both camps have as many slots as the larger one
has pieces; whatever is said of an empty slot is 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

from hexwar_sb3.engine.world import World
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.records import TaskKind

PER_CELL = 1 / 35  # distances and places; 35 cells are half of a built-in map
PER_LEVEL = 1 / 5  # steps of altitude
PER_BLOOD = 1 / 3
PER_COUNT = 1 / 7
PER_VALUE = 1 / 10  # points of a unit or of a shot
PER_WORTH = 1 / 30  # points of a whole piece
PER_POINT = 1 / 80  # points of a control point
PER_MARGIN = 1 / 100
PER_ATTACK = 1 / 10  # attack levels
PER_TIMER = 1 / 75  # ticks of a timer
PER_WAY = 1 / 900  # ticks of travel
PER_GAME = 1 / 1800  # ticks of a game; age of what was seen
PER_HOP = 1 / 125  # base hops of a way: ticks of a hop of that type on open ground; at most 250
PER_DETOUR = 1 / 5  # base hops lost on a way
PER_AGE = 1 / 300  # ticks in which what was seen loses its worth (bots.md, section 1)
MOST = 2.0  # scaled ways and ages are cut off here
BOUND = 16.0  # of every number; steep maps, rich scenarios and long games are cut off here
BIT = 1.0

_KINDS = len(PieceType)
_TASKS = len(TaskKind)


class Times(Enum):
    """How often a group of features is repeated."""

    ONCE = "once"
    NEIGHBOURS = "for each of the 6 neighbours, by direction"
    OWN = "for each own piece, by slot"
    ENEMIES = "for each enemy piece, by slot"
    POINTS = "for each control point"
    PIECES = "for each own, then each enemy piece, by slot"


@dataclass(frozen=True, slots=True)
class Feature:
    """One or more numbers of the same kind."""

    name: str
    width: int | Times  # numbers; Times.OWN: one for each own piece
    scale: float
    source: str


@dataclass(frozen=True, slots=True)
class Group:
    """Features that are written together, once or for each of several things."""

    name: str
    times: Times
    features: tuple[Feature, ...]


OBS = (
    Group("self", Times.ONCE, (
        Feature("type", _KINDS, BIT, "II-A, Fig. 2"),
        Feature("slot", Times.OWN, BIT, "one network for all pieces"),
        Feature("place x, y", 2, PER_CELL, "II-A"),
        Feature("blood", 1, PER_BLOOD, "II-A"),
        Feature("value", 1, PER_VALUE, "II-A"),
        Feature("moving, settled, busy, in close combat", 4, BIT, "rule book, sections 3, 10"),
        Feature("hidden, suppressed", 2, BIT, "II-A"),
        Feature("cool, stop, hide, board, decompress, keep, mortar", 7, PER_TIMER, "II-A, cold_down"),
        Feature("ammunition", 4, BIT, "share of each pool; rule book, section 2"),
        Feature("has passenger", 1, BIT, "rule book, section 2"),
        Feature("distance to own soldier or chariot", 1, PER_CELL, "rule book, section 2"),
        Feature("on control point, concealed", 2, BIT, "II-A"),
        Feature("exposure", 1, BIT, "share of the cells around that see it"),
        Feature("enemies that it sees", 1, PER_COUNT, "II-A, visible"),
        Feature("value of the best shot now, and if it stood", 2, PER_VALUE, "bots.md, section 1"),
        Feature("task kind", _TASKS, BIT, "III-A; the task under way"),
        Feature("walking, staying, ended", 3, BIT, "III-A"),
        Feature("goal dx, dy, distance", 3, PER_CELL, "III-A"),
    )),
    Group("neighbour", Times.NEIGHBOURS, (
        Feature("climb", 1, PER_LEVEL, "III-A; altitude difference"),
        Feature("controllable, passable, paved, concealed, slushy", 5, BIT, "II-A"),
        Feature("ease", 1, BIT, "base hop time / hop time, 0 without a way"),
    )),
    Group("own piece", Times.OWN, (
        Feature("alive, aboard", 2, BIT, "II-A"),
        Feature("dx, dy, distance", 3, PER_CELL, "II-A"),
        Feature("blood", 1, PER_BLOOD, "II-A"),
        Feature("suppressed, hidden", 2, BIT, "II-A"),
    )),
    Group("enemy", Times.ENEMIES, (
        Feature("never seen, destroyed, seen, seen by this piece", 4, BIT, "III-A, u(sigma, t)"),
        Feature("age", 1, PER_GAME, "III-A, t_j"),
        Feature("dx, dy, distance", 3, PER_CELL, "II-A; as last seen"),
        Feature("blood", 1, PER_BLOOD, "II-A; as last seen"),
        Feature("hidden, suppressed, moving", 3, BIT, "II-A; as last seen"),
    )),
    Group("point", Times.POINTS, (
        Feature("dx, dy, distance", 3, PER_CELL, "II-A"),
        Feature("own, enemy's", 2, BIT, "II-A"),
        Feature("value", 1, PER_POINT, "II-A"),
        Feature("way", 1, PER_WAY, "fastest way"),
        Feature("known enemies within 1", 1, PER_COUNT, "rule book, section 4, occupy"),
    )),
    Group("game", Times.ONCE, (
        Feature("time left", 1, PER_GAME, "II-A; the end is terminal"),
        Feature("known margin", 1, PER_MARGIN, "eq. (1) by the camp's knowledge"),
        Feature("blue", 1, BIT, "the frame is mirrored for it"),
    )),
)  # fmt: skip

ROW = (
    Group("task", Times.ONCE, (
        Feature("kind", _TASKS, BIT, "III-A"),
        Feature("under way", 1, BIT, "the piece has this very task"),
        Feature("dx, dy, distance", 3, PER_CELL, "to the cell, or where the target was last seen"),
        Feature("way", 1, PER_WAY, "fastest way there"),
        Feature("possible now", 1, BIT, "the task's action is legal from here"),
        Feature("others on it", 1, PER_COUNT, "own pieces with the same kind and target"),
        Feature("value of the point", 1, PER_POINT, "II-A; 0: no control point"),
        Feature("point own, enemy's", 2, BIT, "II-A"),
        Feature("concealed, exposure", 2, BIT, "II-A; of the cell"),
        Feature("target type", _KINDS, BIT, "II-A"),
        Feature("target's worth", 1, PER_WORTH, "value x blood as last seen"),
        Feature("target's age", 1, PER_AGE, "III-A, u(sigma, t)"),
        Feature("target seen, seen by this piece, hidden, suppressed, moving", 5, BIT, "II-A"),
        Feature("level", 1, PER_ATTACK, "best attack level from here, if it can be seen from here"),
        Feature("value of the action", 1, PER_VALUE, "bots.md, section 1: shot, guided shot or round"),
        Feature("threat", 1, PER_ATTACK, "best attack level of the target against this piece"),
    )),
)  # fmt: skip

STATE = (
    Group("piece", Times.PIECES, (
        Feature("alive, aboard", 2, BIT, "II-A; true state"),
        Feature("place x, y", 2, PER_CELL, "II-A; true state"),
        Feature("blood", 1, PER_BLOOD, "II-A; true state"),
        Feature("hidden, suppressed, seen by an enemy", 3, BIT, "II-A; true state"),
        Feature("cool", 1, PER_TIMER, "II-A; true state"),
    )),
    Group("point", Times.POINTS, (Feature("own, enemy's", 2, BIT, "II-A"),)),
    Group("game", Times.ONCE, (
        Feature("time left", 1, PER_GAME, "II-A"),
        Feature("margin", 1, PER_MARGIN, "eq. (1)"),
        Feature("blue", 1, BIT, "the frame is mirrored for it"),
    )),
)  # fmt: skip

ROUTE = (
    Group("piece", Times.ONCE, (
        Feature("type", _KINDS, BIT, "II-A, Fig. 2"),
        Feature("task kind", _TASKS, BIT, "III-A"),
    )),
    Group("goal", Times.ONCE, (
        Feature("dx, dy, distance", 3, PER_CELL, "III-A; to the right place"),
        Feature("here", 1, BIT, "the piece is at the right place"),
        Feature("way", 1, PER_HOP, "base hops of the fastest way there; 0 without ways"),
    )),
    Group("neighbour", Times.NEIGHBOURS, (
        Feature("climb", 1, PER_LEVEL, "III-A; altitude difference"),
        Feature("controllable, passable, paved, concealed, slushy", 5, BIT, "II-A"),
        Feature("ease", 1, BIT, "base hop time / hop time, 0 without a way"),
        Feature("nearer", 1, BIT, "cells that it is nearer to the right place"),
        Feature("detour", 1, PER_DETOUR, "base hops lost by going that way; 0 without ways"),
    )),
)  # fmt: skip

VECTORS: Mapping[str, tuple[Group, ...]] = {"obs": OBS, "row": ROW, "state": STATE, "route": ROUTE}
TITLES = {
    "obs": "obs: the last axis of `obs`",
    "row": "row: the last axis of `tasks`",
    "state": "state: of the mixer",
    "route": "route: of the lower level",
}


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Widths for either camp of one scenario."""

    obs: int  # Do
    row: int  # Dt
    state: int  # Ds
    route: int  # Dl, the same for every scenario


def sizes(n_own: int, n_enemies: int, n_points: int) -> Sizes:
    """Widths of obs [N, Do], rows [N, K, Dt], state [Ds] and route [Dl]."""
    counts = _counts(n_own, n_enemies, n_points)
    return Sizes(**{name: _width(groups, counts) for name, groups in VECTORS.items()})


def group_width(vector: str, group: str) -> int:
    """Numbers of one thing of a repeated group: of a piece, of a control point."""
    features = next(one.features for one in VECTORS[vector] if one.name == group)
    return sum(feature.width for feature in features if isinstance(feature.width, int))


def feature_index(vector: str, n_own: int, n_enemies: int, n_points: int) -> dict[str, slice]:
    """Where each feature of "obs", "row", "state" or "route" stands: "enemy 2: blood" -> slice."""
    counts = _counts(n_own, n_enemies, n_points)
    places: dict[str, slice] = {}
    at = 0
    for name, feature in _walk(VECTORS[vector], counts):
        width = _feature_width(feature, counts)
        places[f"{name}: {feature.name}"] = slice(at, at + width)
        at += width
    return places


def markdown() -> str:
    """The docs' index of features: one table a vector."""
    lines: list[str] = []
    for vector, groups in VECTORS.items():
        width = _width(groups, _counts(7, 7, 2))
        lines += [
            f"## {TITLES[vector]}",
            "",
            f"{width} numbers with 7 pieces a camp and 2 control points; `from`: the place of the first.",
            "",
        ]
        lines += ["| from | of | feature | numbers | scale | source |", "|---|---|---|---|---|---|"]
        places = {name: place.start for name, place in reversed(feature_index(vector, 7, 7, 2).items())}
        for group in groups:
            first = group.name if group.times is Times.ONCE else f"{group.name} 0"
            lines += [_markdown_row(places[f"{first}: {one.name}"], group, one) for one in group.features]
        lines.append("")
    return "\n".join(lines)


def _markdown_row(start: int, group: Group, feature: Feature) -> str:
    width = feature.width.value if isinstance(feature.width, Times) else feature.width
    name = group.name if group.times is Times.ONCE else f"{group.name}, {group.times.value}"
    return f"| {start} | {name} | {feature.name} | {width} | {feature.scale:.4g} | {feature.source} |"


def _counts(n_own: int, n_enemies: int, n_points: int) -> dict[Times, int]:
    return {
        Times.ONCE: 1,
        Times.NEIGHBOURS: 6,
        Times.OWN: n_own,
        Times.ENEMIES: n_enemies,
        Times.POINTS: n_points,
        Times.PIECES: n_own + n_enemies,
    }


def _walk(groups: tuple[Group, ...], counts: Mapping[Times, int]) -> Iterator[tuple[str, Feature]]:
    """Every feature in the order of writing, with the numbered name of its group."""
    for group in groups:
        for k in range(counts[group.times]):
            name = group.name if group.times is Times.ONCE else f"{group.name} {k}"
            yield from ((name, feature) for feature in group.features)


def _feature_width(feature: Feature, counts: Mapping[Times, int]) -> int:
    return counts[feature.width] if isinstance(feature.width, Times) else feature.width


def _width(groups: tuple[Group, ...], counts: Mapping[Times, int]) -> int:
    return sum(_feature_width(feature, counts) for _, feature in _walk(groups, counts))


def world_sizes(world: World) -> Sizes:
    """Widths of the arrays that either camp of this world sees."""
    return sizes(world.n_slots, world.n_slots, len(world.scenario.points))


ROUTE_WIDTH = sizes(1, 1, 1).route
