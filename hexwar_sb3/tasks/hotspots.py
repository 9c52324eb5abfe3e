"""Hot spots from play (III-C, "Preprocessing"): visits counted in replays, G^L(k), G^B, boundaries.

A visit is one stay: a ground piece came into a cell, by a hop or out of its chariot, and stood there
at least as long as the transition that ends a move. Cells that are only passed do not count, else the
busiest ones are those of the road from the start. A long stay is one visit, not a crowd; a passenger
visits nothing; aerocraft do not count, because they hover where no task of a ground piece can lead.
G^L(k) are the control points and the k most visited cells that every piece can reach, at least
APART_CELLS from the points and SPREAD_CELLS from each other (assumption A30).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import ConfigError, ReplayFileError
from hexwar_sb3.maps.cells import NO_CELL, NO_HOP
from hexwar_sb3.maps.document import Document
from hexwar_sb3.maps.geometry import NO_DIRECTION, SE, SW, E, direction_between
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.rules.enums import Camp, HopClass, PieceType
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.tasks.spots import (
    SPOTS,
    away_from,
    check_spots,
    max_spots,
    overlooking,
    reachable,
    static_spots,
)
from hexwar_sb3.tasks.spots_file import CampSpots, HotSpots

Ints = NDArray[np.int64]

SPREAD_CELLS = 4  # nearer than this, two spots are one place to a task

_COMES = ("arrived", "off")
_GOES = ("aboard", "dead")


class VisitCount:
    """Visits in the games of one map (III-C, "Preprocessing").

    Example:
        >>> from hexwar_sb3.play import record_game
        >>> count = VisitCount()
        >>> count.add(record_game("MA1", "MA2"))
        >>> hot_spots(count.world, count.visits, k=3, source="one game").save("plain.json")
    """

    def __init__(self) -> None:
        self._first: Replay | None = None
        self._visits: Ints = np.zeros((len(SIDES), 0), np.int64)
        self.replays = 0
        self.players: Counter[tuple[str, str]] = Counter()  # (red, blue): games

    def add(self, replay: Replay) -> None:
        """Count one more game.

        Raises:
            ReplayFileError: it is of another map than the first one, or one camp's own record.
        """
        if replay.camp is not None:
            _refuse(replay, "head", f"the record of {replay.camp} only", "a whole replay")
        world = load_world(replay.scenario())
        self._check_map(replay, world)
        visits = count_visits(replay, world)
        self._visits = self._visits + visits if self.replays else visits
        self.replays += 1
        self.players[_player(replay, Camp.RED), _player(replay, Camp.BLUE)] += 1

    def _check_map(self, replay: Replay, world: World) -> None:
        self._first = self._first or replay
        found, expected = world.scenario.hexmap, self.world.scenario.hexmap
        if found.hash != expected.hash:
            due = f'"{expected.name}" ({expected.hash}), the map of {self._first.source}'
            _refuse(replay, "head.scenario.map", f'"{found.name}" ({found.hash})', due)

    @property
    def world(self) -> World:
        """That of the first game."""
        if self._first is None:
            raise ConfigError("no game was counted")
        return load_world(self._first.scenario())

    @property
    def visits(self) -> Ints:
        """[camp, NC]; where the start is its own mirror image, each camp has all visits, in its frame."""
        world, visits = self.world, self._visits
        if not is_mirrored(world.scenario):
            return visits
        mirror = world.cells.mirror
        both: Ints = visits[Camp.RED] + visits[Camp.BLUE][mirror]
        return np.stack([both, both[mirror]])


def is_mirrored(scenario: Scenario) -> bool:
    """Whether map, control points and starts are their own mirror images."""
    hexmap = scenario.hexmap
    mirror = load_world(scenario).cells.mirror
    points = {(int(point.cell), point.value) for point in scenario.points}
    starts = {(piece.camp, piece.kind, int(piece.cell)) for piece in scenario.pieces}
    return (
        hexmap.is_symmetric()
        and points == {(int(mirror[cell]), value) for cell, value in points}
        and starts == {(Camp(Camp.BLUE - camp), kind, int(mirror[cell])) for camp, kind, cell in starts}
    )


def count_visits(replay: Replay, world: World) -> Ints:
    """Visits in one game [camp, NC], of both camps in the map's frame."""
    stays = _Stays(world)
    for number, line in enumerate(replay.lines, start=1):
        if line["type"] == "event" and line.get("kind") in (*_COMES, *_GOES):
            stays.follow(Document(line, str(replay.source), ReplayFileError, f"line {number}"))
    end = Document(replay.end, str(replay.source), ReplayFileError, "end")
    stays.end(end.integer("tick", 0, world.scenario.game_ticks))
    return stays.visits


class _Stays:
    """Where each ground piece stands, and since when, while a game is read."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.pieces = {str(piece): piece for piece in world.scenario.pieces}
        self.least_ticks = int(world.rules[0].stop_ticks)
        self.visits = np.zeros((len(SIDES), world.cells.size), np.int64)
        self._since: dict[str, tuple[CellIndex, int]] = {}  # (cell, tick) by piece

    def follow(self, event: Document) -> None:
        """Take in an event by which a piece comes or goes."""
        event.has("kind", "tick", "piece", "cell")
        hexmap = self.world.scenario.hexmap
        name = event.choice("piece", self.pieces)
        tick = event.integer("tick", 0, self.world.scenario.game_ticks)
        cell = event.cell("cell", event.text("cell"), hexmap.width, hexmap.height)
        if self.pieces[name].kind == PieceType.AEROCRAFT:
            return
        self._leave(name, tick - self._hop_ticks(name, cell))
        if event.data["kind"] in _COMES:
            self._since[name] = (cell, tick)

    def end(self, tick: int) -> None:
        """End the game: what stands now stood until here."""
        for name in list(self._since):
            self._leave(name, tick)

    def _leave(self, name: str, tick: int) -> None:
        """Count the stay that ends at a tick, if it was one."""
        if name not in self._since:
            return
        cell, came = self._since.pop(name)
        if tick - came >= self.least_ticks:
            self.visits[self.pieces[name].camp, cell] += 1

    def _hop_ticks(self, name: str, to: CellIndex) -> int:
        """Ticks of the hop by which a piece left its cell; 0 where it made none."""
        here = self._since.get(name, (to, 0))[0]
        direction = direction_between(self.world.cells, here, to)
        if direction == NO_DIRECTION:
            return 0
        soldier = self.pieces[name].kind == PieceType.SOLDIER
        hop_class = HopClass.SOLDIER if soldier else HopClass.VEHICLE
        return int(self.world.cells[here].hop_ticks[hop_class, direction])


def hot_spots(world: World, visits: Ints, k: int | None = None, *, source: str) -> HotSpots:
    """Choose G^L(k) by visits [camp, NC], with its hull and the map's boundaries.

    Args:
        k: spots beside the control points; None: the usual number, or as many as were visited if they are fewer.

    Raises:
        ConfigError: k is out of range, or fewer than k cells were visited; none was.
    """
    cells = [ranked(world, camp, visits[camp]) for camp in SIDES]
    least = min(map(len, cells))
    if k is None:
        k = max(1, min(SPOTS, least))
    check_spots(world, k)
    if least < k:
        raise ConfigError(f"k is {k}, but only {least} cells were visited: count more games")
    counted = [_by_visits(world, camp, visits[camp]) for camp in SIDES]
    return _joined(world, k, source, cells, counted)


def static_hot_spots(world: World, k: int = SPOTS) -> HotSpots:
    """The static rule's cells, with hull and boundaries: what stands in for a file of visits."""
    check_spots(world, k)
    cells = [static_spots(world, camp, k) for camp in SIDES]
    return _joined(world, k, "static rule", cells, [{}, {}])


def ranked(world: World, camp: int, visits: Ints) -> list[int]:
    """Cells that may be spots by visits [NC], as many as a task set has room for.

    Control points take turns: each the most visited cell left that overlooks it. Then come the others. Ties go to
    the lower cell number in the camp's frame.
    """
    points = [int(point.cell) for point in world.scenario.points]
    allowed = reachable(world, points) & away_from(world, points)
    by_visits = [cell for cell in _by_visits(world, camp, visits) if allowed[cell]]
    chosen: list[int] = []
    for zones in ([overlooking(world, point) for point in points], [allowed]):
        added = True
        while added:
            before = len(chosen)
            for zone in zones:
                free = zone & away_from(world, chosen, SPREAD_CELLS)
                chosen += [cell for cell in by_visits if free[cell]][:1]
            added = len(chosen) > before
    return chosen[: max_spots(world)]


def plane(world: World) -> tuple[Ints, Ints]:
    """Place of every cell, x in half cells and y in rows, north above [NC]: whole numbers, no rounding."""
    return 2 * world.cells.x.astype(np.int64) + world.cells.y % 2, -world.cells.y.astype(np.int64)


def hull_corners(world: World, cells: Iterable[int]) -> list[int]:
    """Corner cells of the convex hull of some cells, counter-clockwise with north above."""
    x, y = plane(world)
    places = sorted((int(x[cell]), int(y[cell]), int(cell)) for cell in set(cells))
    if len(places) <= 2:
        return [cell for _, _, cell in places]
    return [cell for _, _, cell in _chain(places)[:-1] + _chain(places[::-1])[:-1]]


def walls(world: World) -> list[tuple[int, int]]:
    """Pairs of passable neighbours between which a climb of more than `max_climb` stops vehicles.

    Soldiers climb everywhere; a paved hop is never too steep.
    """
    cells = world.cells
    found: list[tuple[int, int]] = []
    for direction in (E, SE, SW):
        to = cells.neighbour[:, direction]
        open_ground = (cells.passable == 1) & (to != NO_CELL) & (cells.passable[to] == 1)
        shut = open_ground & (cells.hop_ticks[:, HopClass.VEHICLE, direction] == NO_HOP)
        found += [(int(cell), int(to[cell])) for cell in np.flatnonzero(shut)]
    return sorted(found)


def _by_visits(world: World, camp: int, visits: Ints) -> dict[int, int]:
    """Visits by cell, the most visited first."""
    numbers = np.arange(visits.size) if camp == Camp.RED else world.cells.mirror
    order = np.lexsort((numbers, -visits))
    return {int(cell): int(visits[cell]) for cell in order if visits[cell] > 0}


def _joined(
    world: World, k: int, source: str, cells: list[list[int]], visits: list[dict[int, int]]
) -> HotSpots:
    points = [int(point.cell) for point in world.scenario.points]
    red, blue = (
        CampSpots(
            cells=tuple(cells[camp]),
            hull=tuple(hull_corners(world, points + cells[camp][:k])),
            visits=visits[camp],
        )
        for camp in SIDES
    )
    return HotSpots(
        hexmap=world.scenario.hexmap, source=source, k=k, camps=(red, blue), walls=tuple(walls(world))
    )


def _chain(places: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """One side of the hull of sorted places (Andrew's monotone chain)."""
    chain: list[tuple[int, int, int]] = []
    for place in places:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], place) <= 0:
            chain.pop()
        chain.append(place)
    return chain


def _turn(a: tuple[int, int, int], b: tuple[int, int, int], p: tuple[int, int, int]) -> int:
    """Positive where p lies to the left of the way from a to b."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _player(replay: Replay, camp: Camp) -> str:
    """Name of who played a camp, as far as the file says it."""
    players: Any = replay.head.get("players")
    player: Any = players.get(camp_name(camp)) if isinstance(players, dict) else None
    name = str(player.get("name")) if isinstance(player, dict) else "unknown"
    return name if name.isprintable() else ascii(name)


def _refuse(replay: Replay, place: str, found: str, expected: str) -> None:
    raise ReplayFileError(replay.source, place, found=found, expected=expected)
