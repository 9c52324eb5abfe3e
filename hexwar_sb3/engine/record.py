"""Writing down a game while it is played: orders, events, and the state every 75 ticks.

The recorder only looks on: whoever makes the steps, `Game` or a loop over a batch, calls
`before_step` and `after_step` around each.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.edit import Change
from hexwar_sb3.engine.game_events import GameEvent, read_events
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.order_rows import read_order
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.engine.roster import SIDES, Roster, camp_name
from hexwar_sb3.engine.score import margin
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import PieceIndex

Line: TypeAlias = dict[str, Any]  # one line of a replay file

STATE_TICKS = 75  # between two state lines (formats/replay.md)
_HASHED = {
    "games": "seed salt point_owner fight_cell fight_next",
    "pieces": "cell sees blood ammo hidden suppressed carrier passenger path_pos path_len arrives_at hop_need"
    " waiting stop_ends stop_forced stop_pending hide_ends board_ends board_kind board_partner"
    " decompress_ends cool_ends mortar_ends keep_ends",
    "memory": "seen cell tick blood",
    "rounds": "status blood_at_launch hit cell impact fired_at land_at end_at judged",
}

_ROOM = {"point_owner": 8, "fight_cell": 16, "fight_next": 16}
_ONE_NUMBER = 64  # pieces


class Recorder:
    """The lines of one game's replay, without head and end."""

    def __init__(self, world: World) -> None:
        self.world, self.roster = world, Roster(world.scenario)
        self.lines: list[Line] = []
        self._next_state_tick = 0
        self._given: dict[int, Order] = {}
        self._advisors: list[Advisor] = []  # of the state before a step with orders, by camp

    def copy(self) -> Recorder:
        """A recorder that goes on from here by itself."""
        other = Recorder(self.world)
        other.lines = list(self.lines)
        other._next_state_tick = self._next_state_tick
        return other

    def before_step(self, state: State, b: int, given: dict[int, Order] | None = None) -> None:
        """Look at game b before a step is made: the states until now, and the orders.

        given: orders as they were written, by piece; others are read from the records.
        """
        game, pieces, memory, _, _, orders, _ = state.game(b)
        self.note_states(state, b, int(game.tick))
        ordered = np.flatnonzero(orders.kind != Action.NULL).tolist()
        self._given = self._read(ordered, orders, pieces) | (given or {})
        clock = game.copy()
        self._advisors = [Advisor(camp, clock, pieces, memory, self.world) for camp in SIDES if ordered]
        self._orders = orders.copy()
        game.log_count = 0

    def _read(self, ordered: list[int], orders: Rows, pieces: Rows) -> dict[int, Order]:
        cells = self.world.cells
        return {i: read_order(PieceIndex(i), orders[i], self.roster, pieces, cells) for i in ordered}

    def after_step(self, state: State, b: int) -> list[GameEvent]:
        """Look at game b after the step: what became of the orders, and what happened."""
        game, _, _, _, _, orders, log = state.game(b)
        self._orders.code = orders.code
        reasons = self._reasons() if self._advisors else {}
        events = [self._with_reason(event, reasons) for event in read_events(game, log, self.roster)]
        if self._advisors:
            self._note_orders(int(game.tick) - 1, reasons)
        quiet = {"type": "event"}
        self.lines += [quiet | event.as_dict() for event in events if event.kind != "refused"]
        return events

    def _reasons(self) -> dict[int, str]:
        """Why orders of this step were refused, by piece."""
        refused = [i for i in self._given if self._orders[i].code != Code.OK]
        return {i: self._reason(i) for i in refused}

    def _reason(self, i: int) -> str:
        advisor = self._advisors[self.roster.camps[i]]
        return advisor.explain(self._given[i], PieceIndex(i), self._orders[i])

    def _with_reason(self, event: GameEvent, reasons: dict[int, str]) -> GameEvent:
        if event.kind != "refused":
            return event
        i = self.roster.index(event.piece)
        return replace(event, order=str(self._given[i]), reason=reasons[i])

    def _note_orders(self, tick: int, reasons: dict[int, str]) -> None:
        for camp in SIDES:
            own = {i: order for i, order in self._given.items() if self.roster.camps[i] == camp}
            if own:
                line = {"type": "orders", "tick": tick, "camp": camp_name(camp)}
                line["orders"] = [str(order) for i, order in own.items() if i not in reasons]
                line["refused"] = [[str(own[i]), reasons[i]] for i in own if i in reasons]
                self.lines.append(line)

    def note_line(self, state: State, b: int, line: Line) -> None:
        """A line of somebody else's, of a tick since the last step; the states until then come first."""
        self.note_states(state, b, line["tick"])
        self.lines.append(line)

    def note_edit(self, tick: int, changes: list[Change]) -> None:
        """A change by hand."""
        changed = [list(change) for change in changes]
        self.lines.append({"type": "edit", "tick": tick, "changes": changed})

    def note_states(self, state: State, b: int, tick: int) -> None:
        """Write the state lines that are due up to this tick; nothing happened since the last step."""
        while self._next_state_tick <= tick:
            self.lines.append(state_line(state, b, self._next_state_tick, self.world, self.roster))
            self._next_state_tick += STATE_TICKS


def state_line(state: State, b: int, tick: int, world: World, roster: Roster) -> Line:
    """A seek point: what a viewer draws, and the hash of everything."""
    game, pieces, rules = state.games[b], state.pieces[b], world.rules[0]
    return {
        "type": "state",
        "tick": tick,
        "hash": state_hash(state, b),
        "margin": {camp_name(camp): int(margin(game, pieces, camp, rules)) for camp in SIDES},
        "owners": [camp_name(owner) for owner in game.point_owner[: game.n_points]],
        "pieces": [_piece_state(i, pieces[i], roster) for i in range(pieces.size)],
    }


def _piece_state(i: int, piece: Row, roster: Roster) -> list[Any]:
    """[name, cell, blood, hidden, suppressed, carrier]."""
    carrier = None if piece.carrier == NO_PIECE else roster.short(piece.carrier)
    cell = None if piece.cell == NO_CELL else roster.cell_name(piece.cell)
    return [roster.names[i], cell, int(piece.blood), int(piece.hidden), int(piece.suppressed), carrier]


def state_hash(state: State, b: int) -> str:
    """Hash of what the rules say of game b, but the clock: 16 hex digits.

    Only named fields count, by value: a field that is added to a record for other ends leaves the
    hashes of old replays as they are.
    """
    digest = hashlib.sha256()
    for array, names in _HASHED.items():
        rows = getattr(state, array)[b]
        for name in names.split():
            digest.update(_hashed(rows[name], name, state, b).astype("<u8").tobytes())
    for piece, path in zip(state.pieces[b], state.paths[b], strict=True):
        digest.update(path[piece.path_pos : piece.path_len].astype("u1").tobytes())
    return digest.hexdigest()[:16]


def _hashed(values: Any, name: str, state: State, b: int) -> Any:
    """A field as the first replays had it, when a camp had 16 pieces at most, a map 8 points, and bits of pieces were one number."""
    game, pieces = state.games[b], state.pieces[b]
    if name in _ROOM:
        return values[: max(_ROOM[name], int(game.n_points if name == "point_owner" else pieces.size))]
    if name == "sees" and pieces.size <= _ONE_NUMBER:
        return values << np.where(pieces.camp == Camp.RED, game.n_red, 0).astype(np.uint64)
    if name == "judged" and pieces.size <= _ONE_NUMBER:
        return values[..., Camp.RED] | values[..., Camp.BLUE] << np.uint64(game.n_red)
    return np.ascontiguousarray(values)
