"""A scenario: a map, the pieces of both camps at the start, and the control points."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeAlias

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.ruleset import default_rules

MAX_SIDE_PIECES = 64
MAX_CONTROL_POINTS = 16
MAX_GAME_TICKS = 30000
MAX_POINT_VALUE = 1000


class Problem(NamedTuple):
    """Something that a scenario may not contain."""

    place: str
    found: str
    expected: str

    def __str__(self) -> str:
        return f"{self.place}: found {self.found}; expected {self.expected}"


class StartError(ConfigError):
    """A start that contradicts the rule book."""

    def __init__(self, name: str, problem: Problem) -> None:
        self.problem = problem
        super().__init__(name, problem)

    def __str__(self) -> str:
        return "scenario {!r}: {}".format(*self.args)


@dataclass(frozen=True, kw_only=True)
class PieceStart:
    """One piece at tick 0: settled, unhidden, at full blood."""

    camp: Camp
    name: str  # type and number: "tank0"; unique within its camp
    kind: PieceType
    cell: int
    home: str | None = None  # a soldier's chariot
    aboard: bool = False  # starts in its home

    def __str__(self) -> str:
        return f"{self.camp.name.lower()}:{self.name}"

    @property
    def stands(self) -> bool:
        """Whether it is a ground piece standing in its cell by itself."""
        return self.kind != PieceType.AEROCRAFT and not self.aboard


@dataclass(frozen=True, kw_only=True)
class ControlPoint:
    """A cell worth points to the camp that holds it (II-A); green at tick 0."""

    name: str
    cell: int
    value: int  # points


@dataclass(frozen=True, eq=False, kw_only=True)
class Scenario:
    """What a game starts from; red's pieces come first."""

    name: str
    hexmap: HexMap
    pieces: tuple[PieceStart, ...]
    points: tuple[ControlPoint, ...]
    game_ticks: int
    net_score: bool = False  # score own - enemy; otherwise eq. (1) literally, green included

    def __post_init__(self) -> None:
        """Check what the rule book says of a start (section 1).

        Raises:
            StartError: with the first thing that is wrong.
        """
        for problem in problems(self):
            raise StartError(self.name, problem)

    @cached_property
    def hash(self) -> str:
        """Hash of all that matters in play, the map's included."""
        pieces = [(p.camp.name, p.name, int(p.cell), p.home, p.aboard) for p in self.pieces]
        points = [(p.name, int(p.cell), p.value) for p in self.points]
        content = (self.hexmap.hash, pieces, points, self.game_ticks, self.net_score)
        return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


ScenarioLike: TypeAlias = str | Path | Scenario
"""A scenario by its name, file or object, as `load_world` takes it."""


def problems(scenario: Scenario) -> Iterator[Problem]:
    """Everything that contradicts the rule book's start (section 1), lazily."""
    homes = {(piece.camp, piece.name): piece for piece in reversed(scenario.pieces)}
    for piece in scenario.pieces:
        yield from _place_problems(piece, scenario.hexmap)
        yield from _home_problems(piece, homes, scenario.hexmap)
    yield from _camp_problems(scenario.pieces)
    yield from _crowd_problems(scenario)
    yield from _point_problems(scenario)
    if not 0 < scenario.game_ticks <= MAX_GAME_TICKS:
        yield Problem("game_ticks", str(scenario.game_ticks), f"1..{MAX_GAME_TICKS}")


def _place_problems(piece: PieceStart, hexmap: HexMap) -> Iterator[Problem]:
    place = f"piece {piece}"
    kind = piece.kind.name.lower()
    if not (piece.name.startswith(kind) and piece.name[len(kind) :].isdecimal()):
        yield Problem(place, f"name {piece.name!r}", f"{kind!r} and a number")
    if piece.camp == Camp.GREEN:
        yield Problem(place, "camp green", "red or blue")
    if not (0 <= piece.cell < hexmap.n_cells and hexmap.playable.flat[piece.cell]):
        yield Problem(place, f"cell index {piece.cell}", "a playable cell")
    elif piece.kind != PieceType.AEROCRAFT:
        yield from _ground_problems(place, piece.cell, hexmap)


def _ground_problems(place: str, cell: int, hexmap: HexMap) -> Iterator[Problem]:
    name = hexmap.cell_name(cell)
    if not hexmap.passable.flat[cell]:
        yield Problem(place, f"impassable cell {name}", "a cell that ground pieces may enter")
    if hexmap.slushy.flat[cell]:
        yield Problem(place, f"slushy cell {name}", "a dry start")


def _home_problems(
    piece: PieceStart, homes: Mapping[tuple[Camp, str], PieceStart], hexmap: HexMap
) -> Iterator[Problem]:
    place = f"piece {piece}"
    if piece.home is None:
        if piece.aboard:
            yield Problem(place, "aboard without a home", "the chariot that carries it")
        return
    if piece.kind != PieceType.SOLDIER:
        yield Problem(place, f"home {piece.home!r}", "a home for soldiers only")
    home = homes.get((piece.camp, piece.home))
    if home is None or home.kind != PieceType.CHARIOT:
        yield Problem(place, f"home {piece.home!r}", "a chariot of its camp")
    elif piece.aboard and home.cell != piece.cell:
        yield Problem(place, f"cell {hexmap.cell_name(piece.cell)}", "its chariot's cell")


def _camp_problems(pieces: tuple[PieceStart, ...]) -> Iterator[Problem]:
    if [p.camp for p in pieces] != sorted(p.camp for p in pieces):
        yield Problem("pieces", "a red piece after a blue one", "red's pieces first")
    for camp, count in Counter(p.camp for p in pieces).items():
        if count > MAX_SIDE_PIECES:
            yield Problem("pieces", f"{count} of {camp.name.lower()}", f"at most {MAX_SIDE_PIECES}")
    for name, count in Counter(str(p) for p in pieces).items():
        if count > 1:
            yield Problem(f"piece {name}", f"{count} of that name", "one")
    passengers = Counter((p.camp, p.home) for p in pieces if p.aboard)
    for (camp, home), count in passengers.items():
        if count > 1:
            yield Problem(f"piece {camp.name.lower()}:{home}", f"{count} soldiers aboard", "at most one")


def _crowd_problems(scenario: Scenario) -> Iterator[Problem]:
    limit = default_rules().number("stack_limit")
    camps: dict[int, list[Camp]] = {}
    for piece in scenario.pieces:
        if piece.stands:
            camps.setdefault(piece.cell, []).append(piece.camp)
    for cell, present in camps.items():
        place = f"cell {scenario.hexmap.cell_name(cell)}"
        if len(set(present)) > 1:
            yield Problem(place, "ground pieces of both camps", "one camp")
        if len(present) > limit:
            yield Problem(place, f"{len(present)} ground pieces", f"at most {limit}")


def _point_problems(scenario: Scenario) -> Iterator[Problem]:
    points, hexmap = scenario.points, scenario.hexmap
    if len(points) > MAX_CONTROL_POINTS:
        yield Problem("points", str(len(points)), f"at most {MAX_CONTROL_POINTS}")
    for values in ([p.name for p in points], [p.cell for p in points]):
        if len(set(values)) < len(values):
            yield Problem("points", f"{values}", "all different")
    for point in points:
        place = f"point {point.name}"
        if not 0 <= point.cell < hexmap.n_cells:
            yield Problem(place, f"cell index {point.cell}", "a playable cell")
        elif not (hexmap.controllable.flat[point.cell] and hexmap.passable.flat[point.cell]):
            yield Problem(place, f"cell {hexmap.cell_name(point.cell)}", "a controllable, passable cell")
        if not 0 < point.value <= MAX_POINT_VALUE:
            yield Problem(place, f"value {point.value}", f"1..{MAX_POINT_VALUE}")
