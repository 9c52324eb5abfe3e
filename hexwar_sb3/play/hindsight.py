"""What recorded pieces were about: by the tasks that their record has, or in hindsight, by their orders and ways."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hexwar_sb3.engine.orders import (
    Decompress,
    GetOff,
    GetOn,
    GuideShoot,
    Hide,
    IndirectShoot,
    Order,
    Shoot,
)
from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.replay_file import fail
from hexwar_sb3.engine.roster import Roster, camp_name, enemy_of
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import HexWarError, OrderError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.document import shown
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.play.recorded import STOPS, Aim
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.tasks.known import is_known
from hexwar_sb3.tasks.records import TaskKind

_AT_PIECE = (TaskKind.ATTACK, TaskKind.GUIDE, TaskKind.BOMBARD, TaskKind.SHADOW, TaskKind.BOARD)
_AT_CELL = (TaskKind.HOLD, TaskKind.HIDE, TaskKind.DROP)


class Decided:
    """Aims of a camp whose record has its decisions: the task that each piece had last been given.

    Args:
        pieces: numbers of the camp's pieces.
        given: (tick, piece, task), in the order of the game.
    """

    def __init__(self, pieces: Sequence[int], given: Sequence[tuple[int, int, Aim]]) -> None:
        self._ticks = {i: [tick for tick, one, _ in given if one == i] for i in pieces}
        self._aims = {i: [aim for _, one, aim in given if one == i] for i in pieces}

    def at(self, tick: int, until: int, memory: Rows) -> list[list[Aim]]:
        """The task of each piece after the decision of a tick."""
        numbers = {i: bisect_right(ticks, tick) for i, ticks in self._ticks.items()}
        return [[self._aims[i][number - 1] if number else STOPS] for i, number in numbers.items()]


def decided_aims(replay: Replay, camp: Camp, roster: Roster) -> Decided | None:
    """What the record says that a camp decided; None where it says nothing.

    Raises:
        ReplayFileError: a task is none.
    """
    given: list[tuple[int, int, Aim]] = []
    for number, line in enumerate(replay.lines, start=1):
        if line["type"] == "decision" and line["camp"] == camp_name(camp):
            given += [(line["tick"], *one) for one in _choices(replay, camp, roster, number, line)]
    return Decided(roster.pieces_of(camp), given) if given else None


def _choices(
    replay: Replay, camp: Camp, roster: Roster, number: int, line: Line
) -> Iterator[tuple[int, Aim]]:
    for piece, chosen, tasks, _, _ in line["choices"]:
        try:
            yield int(roster.own_index(camp, piece)), read_task(tasks[chosen], roster)
        except HexWarError as error:
            fail(replay.source, f"line {number}, decision", f"{shown(tasks[chosen])}: {error}", "a task")


def read_task(text: str, roster: Roster) -> Aim:
    """Read a task as a decision has it: "hold 1134", "attack blue:tank0", "stop".

    Raises:
        HexWarError: it is none.
    """
    verb, _, where = text.partition(" ")
    kind = TaskKind.__members__.get(verb.upper())
    if kind is None or bool(where) != (kind in (*_AT_PIECE, *_AT_CELL)):
        raise OrderError(f"{shown(text)} is no task")
    if kind in _AT_PIECE:
        return Aim(kind, target=int(roster.index(where)))
    return Aim(kind, cell=int(roster.cell(where))) if where else Aim(kind)


class Stay(NamedTuple):
    """A time for which a piece stood in a cell."""

    cell: int
    since: int  # tick
    until: int  # tick


class Deeds:
    """Where the pieces of a game stood, and what they were ordered to do, written down while it is played again."""

    def __init__(self, n_pieces: int) -> None:
        self._now: list[tuple[int, bool]] = [(NO_CELL, False)] * n_pieces
        self._ways: list[list[tuple[int, int, bool]]] = [[] for _ in range(n_pieces)]  # (tick, cell, stands)
        self.orders: list[list[tuple[int, Order]]] = [[] for _ in range(n_pieces)]  # by piece

    def note_pieces(self, tick: int, pieces: Rows) -> None:
        """Note where the pieces are at a tick, and whether they stand [P]."""
        now = list(zip(pieces.cell.tolist(), (pieces.arrives_at == NEVER).tolist(), strict=True))
        for way, place, before in zip(self._ways, now, self._now, strict=True):
            if place != before:
                way.append((tick, *place))
        self._now = now

    def note_order(self, i: int, tick: int, order: Order) -> None:
        """Note an order of piece i."""
        self.orders[i].append((tick, order))

    def stays(self, i: int, least_ticks: int) -> list[Stay]:
        """Where piece i stood for so many ticks or more; last where it was in the end."""
        ends = [*(tick for tick, _, _ in self._ways[i][1:]), NEVER]
        stays = [Stay(cell, since, end) for (since, cell, _), end in zip(self._ways[i], ends, strict=True)]
        stands = [stands or end == NEVER for (_, _, stands), end in zip(self._ways[i], ends, strict=True)]
        return [
            stay
            for stay, one in zip(stays, stands, strict=True)
            if one and stay.until - stay.since >= least_ticks
        ]


class Hindsight:
    """Aims of a camp of which the orders alone are known, as those of a person: what its pieces did, they were about.

    A piece is about the place where it stands at the next decision and for as long as a stop takes, or where it next
    does so. By falling likeliness it boards or sets down a soldier there, comes out of suppression before the next
    decision, hides there, holds a control point there, fires at somebody before the next decision, or holds the place.
    """

    def __init__(self, world: World, camp: Camp, deeds: Deeds) -> None:
        self.world, self.camp, self.roster = world, camp, Roster(world.scenario)
        self._points = {int(point.cell) for point in world.scenario.points}
        self._pieces = self.roster.pieces_of(camp)
        self._orders = {i: deeds.orders[i] for i in self._pieces}
        self._stays = {i: deeds.stays(i, int(world.rules[0].stop_ticks)) for i in self._pieces}

    def at(self, tick: int, until: int, memory: Rows) -> list[list[Aim]]:
        """What each piece is about from a decision on."""
        return [list(dict.fromkeys(self._of(i, tick, until, memory))) for i in self._pieces]

    def _of(self, i: PieceIndex, tick: int, until: int, memory: Rows) -> Iterator[Aim]:
        stay = next(one for one in self._stays[i] if one.until >= until)
        now = [order for given, order in self._orders[i] if tick <= given < until]
        there = [(given, order) for given, order in self._orders[i] if stay.since <= given < stay.until]
        yield from self._boarding([*now, *(order for given, order in there if given >= tick)], stay.cell)
        if any(isinstance(order, Hide) for _, order in there):
            yield Aim(TaskKind.HIDE, cell=stay.cell)
        place = Aim(TaskKind.HOLD, cell=stay.cell)
        if stay.cell in self._points:
            yield place
        yield from self._shots(now, memory)
        yield place

    def _boarding(self, orders: Sequence[Order], cell: int) -> Iterator[Aim]:
        """What orders to come say of soldiers and their chariots, and of suppression."""
        for order in orders:
            match order:
                case GetOn():
                    yield Aim(TaskKind.BOARD, target=int(self.roster.index_in(self.camp, order.chariot)))
                case GetOff():
                    yield Aim(TaskKind.DROP, cell=cell)
                case Decompress():
                    yield Aim(TaskKind.RECOVER)

    def _shots(self, orders: Sequence[Order], memory: Rows) -> Iterator[Aim]:
        """Whom orders are against."""
        for order in orders:
            match order:
                case Shoot():
                    yield Aim(TaskKind.ATTACK, target=self._enemy(order.target))
                case GuideShoot():
                    yield Aim(TaskKind.GUIDE, target=self._enemy(order.target))
                case IndirectShoot():
                    yield Aim(
                        TaskKind.BOMBARD, target=self._nearest_enemy(self.roster.cell(order.cell), memory)
                    )

    def _enemy(self, name: str) -> int:
        return int(self.roster.index_in(enemy_of(self.camp), name))

    def _nearest_enemy(self, cell: CellIndex, memory: Rows) -> int:
        """The known enemy that was last seen nearest to a cell; NO_PIECE, which no task is against, without any."""
        enemies = [j for j in self.roster.pieces_of(enemy_of(self.camp)) if is_known(memory[j])]
        apart = {int(j): int(cells_apart(self.world.cells, memory[j].cell, cell)) for j in enemies}
        return min(apart, key=lambda j: apart[j], default=NO_PIECE)
