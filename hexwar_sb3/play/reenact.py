"""Reading recorded games that are to be shown: each is played again before the training, and must come out as recorded."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import numpy as np

from hexwar_sb3.bots.registry import as_member, is_bot
from hexwar_sb3.engine.order_rows import read_order, write_order
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.record import Line, state_hash
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.replay_file import fail
from hexwar_sb3.engine.roster import SIDES, Roster, camp_name, parse_camp
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.document import shown
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.hindsight import Deeds, Hindsight, decided_aims
from hexwar_sb3.play.recorded import NOTHING, RecordedGame, Script, Turns
from hexwar_sb3.players.player import BotPlayer, bot_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import PieceIndex


def read_recorded(path: Path, world: World) -> RecordedGame:
    """Read a game of a scenario and play it again.

    Raises:
        ReplayFileError: it is damaged, one camp's own record, of another scenario, map or rules, or changed by hand; or it
            does not come out as recorded.
    """
    replay = Replay.load(path)
    _check_fits(replay, world)
    return Reenactment(replay, world).play()


def _check_fits(replay: Replay, world: World) -> None:
    refuse: Callable[[str, str, str], NoReturn] = lambda *what: fail(replay.source, *what)  # noqa: E731
    if replay.camp is not None:
        refuse("head", f"the record of {replay.camp} only", "a whole replay")
    found, own = replay.scenario(), world.scenario
    if found.hexmap.hash != own.hexmap.hash:
        refuse("head.scenario.map", _name(found.hexmap), _name(own.hexmap))
    if found.hash != own.hash:
        refuse("head.scenario", _name(found), _name(own))
    rules = replay.ruleset()
    if rules.hash != world.ruleset.hash:
        refuse("head.rules.aerocraft", rules.aerocraft.name, world.ruleset.aerocraft.name)
    if not replay.end["tick"]:
        refuse("end.tick", "0", "a game of which something was played")
    for number, line in enumerate(replay.lines, start=1):
        if line["type"] == "edit":
            refuse(
                f"line {number}", "a change by hand", "a game that was played from its start by orders alone"
            )


def _name(thing: object) -> str:
    return f'"{getattr(thing, "name", "")}" ({getattr(thing, "hash", "")})'


def shown_camps(replay: Replay) -> tuple[Camp, ...]:
    """Camps of a game that a learner may watch: those of people; else the winner's, without one both."""
    people = [camp for camp in SIDES if _player(replay, camp).get("kind") == "human"]
    winner = replay.end["winner"]
    won = [parse_camp(winner)] if winner in map(camp_name, SIDES) else list(SIDES)
    return tuple(people or won)


def _player(replay: Replay, camp: Camp) -> dict[str, str]:
    player: dict[str, str] = replay.head.get("players", {}).get(camp_name(camp), {})
    return player


class Reenactment:
    """One recorded game, played again with all that is looked at on the way."""

    def __init__(self, replay: Replay, world: World) -> None:
        self.replay, self.world, self.roster = replay, world, Roster(world.scenario)
        self.arena = Arena(world, 1, Terms(scenario=world.scenario))
        self.bots = [self._bot(camp) for camp in SIDES]  # that gave just these orders, so far
        self.steps: dict[int, dict[int, Rows]] = {}  # ORDER records by tick and piece
        self.deeds = Deeds(world.n_pieces)
        numbered = list(enumerate(replay.lines, start=1))
        self._orders = [(number, line) for number, line in numbered if line["type"] == "orders"]
        self._states = [(number, line) for number, line in numbered if line["type"] == "state"]

    def _bot(self, camp: Camp) -> BotPlayer | None:
        """The scripted player that is said to have played a camp."""
        name = _player(self.replay, camp).get("name")
        return bot_player(*as_member(name)) if name is not None and is_bot(name) else None

    def play(self) -> RecordedGame:
        """Play it to its end.

        Raises:
            ReplayFileError: the first line that cannot be played, or a state or an end that differ.
        """
        self.arena.begin(0, self.replay.seed, *self.bots)
        turns, end = Turns(self.arena, 0), int(self.replay.end["tick"])
        while not turns.game.over and turns.game.tick < end:
            tick = int(turns.game.tick)
            self._check_states(tick)
            self.deeds.note_pieces(tick, turns.pieces)
            turns.think()
            given = self._give(tick, turns.orders, turns.pieces)
            next_orders = self._orders[0][1]["tick"] if self._orders else end
            turns.go_on(min(next_orders, end), given=given)
        self._check_end(int(turns.game.tick))
        return self._result()

    def _give(self, tick: int, orders: Rows, pieces: Rows) -> bool:
        """Write the orders of this tick in place of what bots thought [P]; False where there are none."""
        thought = self._thought(orders, pieces)
        told, given = dict[int, str](), bool(self._orders) and self._orders[0][1]["tick"] == tick
        orders[:] = NOTHING
        while self._orders and self._orders[0][1]["tick"] == tick:
            told |= self._write(*self._orders.pop(0))
        if given:
            self.steps[tick] = {i: orders[i].copy() for i in told}
        for camp in SIDES:
            own = set(self.roster.pieces_of(camp))
            if {i: thought[i] for i in own & thought.keys()} != {i: told[i] for i in own & told.keys()}:
                self.bots[camp] = None
        return given

    def _thought(self, orders: Rows, pieces: Rows) -> dict[int, str]:
        """Orders that the bots would give now, by piece."""
        given = np.flatnonzero(orders.kind != Action.NULL).tolist()
        return {
            i: str(read_order(PieceIndex(i), orders[i], self.roster, pieces, self.world.cells)) for i in given
        }

    def _write(self, number: int, line: Line) -> dict[int, str]:
        """Write a line of orders, those that were refused too: the engine refuses them again; their texts by piece."""
        camp, told = parse_camp(line["camp"]), dict[int, str]()
        for text in line["orders"]:
            try:
                told |= self._write_one(camp, text)
            except HexWarError as error:
                fail(self.replay.source, f"line {number}", str(error), "orders that can be played again")
        for text, _ in line.get("refused", ()):
            with suppress(HexWarError):
                told |= self._write_one(camp, text)
        return told

    def _write_one(self, camp: Camp, text: str) -> dict[int, str]:
        order = Order.parse(text)
        state, i = self.arena.state, self.roster.own_index(camp, order.piece)
        write_order(order, i, state.orders[0, i], self.roster, state.pieces[0], self.world.cells)
        self.deeds.note_order(i, int(state.games[0].tick), order)
        return {int(i): text}

    def _check_states(self, tick: int) -> None:
        """Compare the states that the file has up to this tick."""
        while self._states and self._states[0][1]["tick"] <= tick:
            number, line = self._states.pop(0)
            again = state_hash(self.arena.state, 0)
            if again != line["hash"]:
                place = f"line {number}, state of tick {line['tick']}"
                fail(self.replay.source, place, f'"{again}" when played again', shown(line["hash"]))

    def _check_end(self, tick: int) -> None:
        self._check_states(tick)
        for number, line in (*self._orders, *self._states):
            fail(
                self.replay.source,
                f"line {number}.tick",
                str(line["tick"]),
                f"the end at {tick}, as played again",
            )
        margins = self.arena.margins(np.zeros(2, np.int64), np.arange(2)).tolist()
        over = bool(self.arena.state.games[0].over)
        again = {"tick": tick, "over": over, "margin": dict(zip(map(camp_name, SIDES), margins, strict=True))}
        told = {key: self.replay.end[key] for key in again}
        if again != told:
            fail(self.replay.source, "end", f"{shown(again)} when played again", shown(told))

    def _result(self) -> RecordedGame:
        replay = self.replay
        red, blue = (_player(replay, camp).get("name", "unknown") for camp in SIDES)
        aims = [
            decided_aims(replay, camp, self.roster) or Hindsight(self.world, camp, self.deeds)
            for camp in SIDES
        ]
        return RecordedGame(
            source=replay.source,
            sha256=replay.end["sha256"],
            seed=replay.seed,
            end_tick=replay.end["tick"],
            names=(red, blue),
            shows=shown_camps(replay),
            script=Script.of(self.steps),
            bots=(self.bots[Camp.RED], self.bots[Camp.BLUE]),
            aims=(aims[Camp.RED], aims[Camp.BLUE]),
        )
