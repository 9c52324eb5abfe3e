"""A recorded game that is played again in an arena: its dice, the orders of both camps, and what they were for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.order_rows import clear_order
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE, ORDER
from hexwar_sb3.kernels import Rows
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.drive import act, jump, make_step, next_decision, note_due
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.players.player import BotPlayer, Seat
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CampIndex
from hexwar_sb3.tasks.choose import new_missions
from hexwar_sb3.tasks.records import TaskKind

Ints = NDArray[np.int64]

NOTHING = np.zeros(1, ORDER).view(np.recarray)[0]  # the record of no order
clear_order(NOTHING)


@dataclass(frozen=True)
class Aim:
    """What a piece was about: a kind of task, and its target or cell."""

    kind: TaskKind
    target: int = NO_PIECE
    cell: int = NO_CELL


STOPS = Aim(TaskKind.STOP)


class Aims(Protocol):
    """Says what the pieces of a camp were about, by its record."""

    def at(self, tick: int, until: int, memory: Rows) -> Sequence[Sequence[Aim]]:
        """Aims of each piece of the camp from a tick on, the likeliest first.

        Args:
            tick: of the decision.
            until: tick of the next one.
            memory: what the camp knows of every piece at that tick, MEMORY [P].
        """


@dataclass(frozen=True)
class Script:
    """The orders of both camps, as the engine takes them, by the tick in which they were given.

    Args:
        ticks: in which somebody gave an order, rising [S].
        first: the orders of ticks[s] are those from first[s] to first[s + 1] [S + 1].
        pieces: who got each order [R].
        orders: ORDER records [R].
    """

    ticks: Ints
    first: Ints
    pieces: Ints
    orders: Rows

    @classmethod
    def of(cls, steps: dict[int, dict[int, Rows]]) -> Script:
        """Put together the orders of each tick, by piece."""
        ticks = sorted(steps)
        pieces = [i for tick in ticks for i in steps[tick]]
        rows = np.zeros(len(pieces), ORDER).view(np.recarray)
        for k, order in enumerate(one for tick in ticks for one in steps[tick].values()):
            rows[k] = order
        first = np.cumsum([0, *(len(steps[tick]) for tick in ticks)])
        return cls(np.array(ticks, np.int64), first, np.array(pieces, np.int64), rows)

    def give(self, tick: int, orders: Rows) -> bool:
        """Write the orders of a tick in place of all others [P]; False where none were given.

        A tick in which every order was refused has none, but its step is made.
        """
        orders[:] = NOTHING
        step = int(np.searchsorted(self.ticks, tick))
        if step == len(self.ticks) or self.ticks[step] != tick:
            return False
        span = slice(self.first[step], self.first[step + 1])
        orders[self.pieces[span]] = self.orders[span]
        return True

    def next_after(self, tick: int) -> int:
        """The next tick in which orders are given; NEVER if there is none."""
        step = int(np.searchsorted(self.ticks, tick, side="right"))
        return int(self.ticks[step]) if step < len(self.ticks) else NEVER


@dataclass(frozen=True)
class RecordedGame:
    """A game that was played again and found true, to be shown to a learner.

    A camp whose bot thinks along, and gives just the orders of the record, has that bot's own missions; of another one
    `aims` say what its pieces were about.
    """

    source: Path
    sha256: str  # of its lines
    seed: int  # of all dice
    end_tick: int  # as far as it is recorded: to its end, or until it was broken off
    names: tuple[str, str]  # of who played (red, blue)
    shows: tuple[Camp, ...]  # camps that may be learned from
    script: Script
    bots: tuple[BotPlayer | None, BotPlayer | None]  # that think along (red, blue)
    aims: tuple[Aims, Aims]  # of (red, blue)

    def seats(self, camp: Camp) -> tuple[Seat | None, Seat | None]:
        """Who sits where while a camp is shown: the bot that thinks along, or nobody."""
        return (self.bots[0], None) if camp == Camp.RED else (None, self.bots[1])

    def play(self, arena: Arena, b: int) -> None:
        """Play game b of an arena on to the next decision of a camp that is asked, or to the end."""
        turns, due = Turns(arena, b), False
        while not (due or turns.game.over):
            tick = int(turns.game.tick)
            turns.think()
            given = self.script.give(tick, turns.orders)
            due = turns.go_on(self.script.next_after(tick), given=given)

    def choose(self, arena: Arena, b: int, camp: Camp, until: int, sight: Sight, slot: int) -> None:
        """Give the pieces of a camp without a bot the tasks that come nearest to what they were about.

        Args:
            arena: that plays this game as its game b.
            b: likewise.
            camp: that is shown.
            until: tick of its next decision.
            sight: what it sees, in a slot.
            slot: likewise.
        """
        state = arena.state
        aims = self.aims[camp].at(int(state.games[b].tick), until, state.memory[b, camp])
        tasks = nearest_tasks(arena, b, camp, aims, sight, slot)
        arena.choose(np.array([slot]), np.array([b]), np.array([camp]), tasks[None], sight)


def nearest_tasks(
    arena: Arena, b: int, camp: Camp, aims: Sequence[Sequence[Aim]], sight: Sight, slot: int
) -> Ints:
    """Name the aims of each piece as `name_missions` names a bot's: the first that is in its task set [N].

    Stop, which is task 0, where none is, and in slots without a piece.
    """
    tasks = np.zeros(arena.world.n_slots, np.int64)
    named = np.zeros(arena.world.n_slots, np.bool_)
    for rank in range(max(map(len, aims), default=0)):
        now = [own[rank] if rank < len(own) else STOPS for own in aims]
        found = arena.name_missions(b, CampIndex(camp), sight, slot, _missions_of(arena, camp, now))
        tasks = np.where(named, tasks, found)
        named |= found > 0
        named[: len(now)] |= np.array([aim.kind == TaskKind.STOP for aim in now])
    return tasks


def _missions_of(arena: Arena, camp: Camp, aims: Sequence[Aim]) -> Rows:
    """The aims of a camp's pieces as missions of all pieces [P]."""
    missions = new_missions(1, arena.world.n_pieces)[0]
    for mission, aim in zip(missions[arena.world.side(camp)], aims, strict=True):
        mission.kind, mission.target, mission.cell = aim.kind, aim.target, aim.cell
    return missions


class Turns:
    """Turns of one game of an arena, in which others than its players give the orders.

    `advance_game` of the drive loop does in one turn what `think` and `go_on` do together.
    """

    def __init__(self, arena: Arena, b: int) -> None:
        self._world, self._nets, self._atlas = arena.world, arena.nets, arena.atlas[0]
        self._rules = arena.world.rules[0]
        state = arena.state.game(b)
        self.game, self.pieces, self._memory, self._paths, self._rounds, self.orders, self._log = state
        self._drive, self._missions, self._brains = arena.drives[b], arena.missions[b], arena.brains[b]

    def think(self) -> None:
        """Let both camps act as in the drive loop: orders, which nobody needs, and how far their tasks have come."""
        world = self._world
        act(
            self._drive, self.game, self.pieces, self._memory, self._paths, self._rounds, self.orders,
            self._missions, self._brains, self._rules, world.cells, world.los, world.eta, self._atlas, self._nets,
        )  # fmt: skip

    def go_on(self, next_orders: int, *, given: bool) -> bool:
        """Make a step, or jump to where something is due; True if an asked camp is to decide there.

        In `orders` lie those of this tick, and no others.

        Args:
            next_orders: tick in which there will be orders again.
            given: there are some in this tick.
        """
        decides = next_decision(self._drive, self.game)
        until = min(decides, next_orders)
        steps = given or not jump(until, self._drive, self.game, self.pieces, self._rounds)
        if steps:
            make_step(
                self._drive, self.game, self.pieces, self._memory, self._paths, self._rounds, self.orders,
                self._log, self._rules, self._world.cells, self._world.los,
            )  # fmt: skip
        return (steps or self.game.tick == decides) and bool(note_due(self._drive, self.game, self._missions))
