"""Changing a game by hand, for scenario editors and tests; checked as a whole at the end.

    with game.edit() as state:
        state["blue:tank0"].cell = "4034"
        state["main"].owner = "red"

Every change is a word (who, field, value), so that a replay can hold it and make it again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, cast

from hexwar_sb3.engine.fights import close_fights, open_fights
from hexwar_sb3.engine.harm import die_with_passenger
from hexwar_sb3.engine.movement import start_hops
from hexwar_sb3.engine.order_rows import write_order
from hexwar_sb3.engine.orders import Move, did_you_mean, weapon_name
from hexwar_sb3.engine.pieces import count_in, hop_from, is_ground, on_map, stands_in
from hexwar_sb3.engine.records import NEVER, NO_PIECE
from hexwar_sb3.engine.roster import Roster, camp_name, parse_camp
from hexwar_sb3.engine.sight import look_all, remember
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.view import side_view
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import Camp, PieceType, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex, piece_range

Value: TypeAlias = Any  # str, int, bool, None or a list of str: what JSON holds
Change: TypeAlias = tuple[str, str, Value]  # who, field, value

MAX_AMMO = 127
MAX_TIMER_TICKS = 1000


class Editor:
    """What `game.edit()` gives: pieces and control points by name."""

    def __init__(self, state: State, world: World) -> None:
        self._state, self._world = state, world
        self.roster = Roster(world.scenario)
        self.changes: list[Change] = []

    def __getitem__(self, name: str) -> Entry:
        if any(point.name == name for point in self._world.scenario.points):
            return Entry(self, name, _POINT_FIELDS)
        self.roster.index(name)
        return Entry(self, name, _PIECE_FIELDS)

    def apply(self, change: Change) -> None:
        """Make one change.

        Raises:
            ConfigError: no such field, or a value that it cannot have.
        """
        name, field, value = change
        entry = self[name]
        write = entry.field(field)
        try:
            write(self, name, value)
        except (TypeError, ValueError, LookupError, OverflowError, AttributeError) as error:
            if isinstance(error, ConfigError):
                raise
            raise ConfigError(f"{name}.{field} cannot be {value!r}: {error}") from error
        self.changes.append(change)

    def read(self, name: str, field: str) -> Value:
        """The present value of a field; of a timer, the ticks left."""
        if field == "owner":
            return camp_name(self._state.games[0].point_owner[self.roster.point_index(name)])
        i = self.roster.index(name)
        view = side_view(self.roster.camps[i], self._state, 0, self._world)
        value = getattr(view.piece(self.roster.short(i)), _SHOWN_AS.get(field, field))
        return dict(value) if field == "ammo" else value

    def finish(self) -> None:
        """Check the whole position and bring everything derived up to date.

        Raises:
            ConfigError: the position is not possible under the rules.
        """
        game, pieces, memory, paths, _, _, log = self._state.game(0)
        rules, cells, los = self._world.tables
        for i in range(pieces.size):
            self._check_piece(i, pieces, cells)
        self._check_crowds(pieces, rules)
        for i in piece_range(pieces.size):
            if pieces[i].blood == 0:
                die_with_passenger(i, game, pieces, log)
        close_fights(game, pieces)
        running = game.fight_cell.copy()
        open_fights(game, pieces, log)
        game.fight_next[game.fight_cell != running] = game.tick  # contact is in this state
        start_hops(game.tick, game, pieces, paths, log, rules, cells)
        look_all(pieces, rules, cells, los)
        remember(game, pieces, memory, paths, cells)
        game.log_count = 0

    def _check_piece(self, i: int, pieces: Rows, cells: Rows) -> None:
        piece, cell = pieces[i], cells[pieces[i].cell]
        if on_map(piece) and is_ground(piece) and not cell.passable:
            name = self.roster.cell_name(piece.cell)
            raise ConfigError(f"{self.roster.spoken(i)} cannot stand in {name}: it is impassable")

    def _check_crowds(self, pieces: Rows, rules: Row) -> None:
        for i in range(pieces.size):
            crowd = count_in(pieces, pieces[i].camp, pieces[i].cell)
            if stands_in(pieces[i], pieces[i].cell) and crowd > rules.stack_limit:
                name = self.roster.cell_name(pieces[i].cell)
                found = f"{crowd} {camp_name(pieces[i].camp)} ground pieces"
                raise ConfigError(f"cell {name} holds {found}; expected at most {rules.stack_limit}")

    # --- fields of a piece -----------------------------------------------------------------------

    def _piece(self, name: str) -> tuple[int, Row]:
        i = self.roster.index(name)
        return i, self._state.pieces[0, i]

    def set_cell(self, name: str, value: Value) -> None:
        """Put the piece, and its passenger, into the middle of a cell."""
        _, piece = self._piece(name)
        piece.cell = self.roster.cell(value)
        self.set_path(name, [])
        if piece.passenger != NO_PIECE:
            self._state.pieces[0, piece.passenger].cell = piece.cell

    def set_path(self, name: str, value: Value) -> None:
        """Send the piece on its way from here: names of the cells to walk; [] stands."""
        i, piece = self._piece(name)
        cells, rules, paths = self._world.cells, self._world.rules[0], self._state.paths[0]
        row = self._state.orders[0, i].copy()
        write_order(Move(name, value), PieceIndex(i), row, self.roster, self._state.pieces[0], cells)
        here = CellIndex(piece.cell)
        for k, direction in enumerate(row.path[: row.path_len]):
            if direction >= len(cells[here].neighbour) or not hop_from(
                piece.kind, here, direction, rules, cells
            ):
                raise ValueError(f"hop {k + 1} is not possible")
            paths[i, k] = direction
            here = CellIndex(cells[here].neighbour[direction])
        piece.path_pos, piece.path_len, piece.waiting, piece.stop_pending = 0, row.path_len, 0, 0
        piece.arrives_at, piece.stop_ends, piece.stop_forced = NEVER, NEVER, 0

    def set_blood(self, name: str, value: Value) -> None:
        """Set the vehicles or squads left; 0 destroys the piece."""
        _, piece = self._piece(name)
        piece.blood = _whole(value, int(self._world.rules[0].blood[piece.kind]))

    def set_hidden(self, name: str, value: Value) -> None:
        """Hide or show a ground piece."""
        _, piece = self._piece(name)
        if value and not is_ground(piece):
            raise ValueError("an aerocraft never hides")
        piece.hidden = bool(value)

    def set_suppressed(self, name: str, value: Value) -> None:
        """Suppress for so many ticks; True: as fire does; 0 or False: not at all."""
        _, piece = self._piece(name)
        if value and not is_ground(piece):
            raise ValueError("an aerocraft is never suppressed")
        full = int(self._world.rules[0].keep_ticks) - 1  # as the last step would have left it
        ticks = full if value is True else _whole(int(value), full)
        piece.suppressed = ticks > 0
        piece.keep_ends = self._end(ticks)

    def set_cool(self, name: str, value: Value) -> None:
        """Set the ticks until direct and guided fire is possible again."""
        self._piece(name)[1].cool_ends = self._end(_whole(value, MAX_TIMER_TICKS))

    def set_mortar_cool(self, name: str, value: Value) -> None:
        """Set the ticks until the mortar is cool."""
        self._piece(name)[1].mortar_ends = self._end(_whole(value, MAX_TIMER_TICKS))

    def set_stopping(self, name: str, value: Value) -> None:
        """Put the piece into a stop transition: "natural", "forced", or None to end it."""
        _, piece = self._piece(name)
        if value not in {"natural", "forced", None}:
            raise ValueError("expected 'natural', 'forced' or None")
        self.set_path(name, [])
        piece.stop_ends = NEVER if value is None else self._end(int(self._world.rules[0].stop_ticks) - 1)
        piece.stop_forced = value == "forced"

    def set_ammo(self, name: str, value: Value) -> None:
        """Set rounds by weapon: {"GUN": 3}; weapons that share them change together."""
        _, piece = self._piece(name)
        pools = self._world.rules[0].pool[piece.kind]
        for weapon, rounds in dict(value).items():
            pool = pools[Weapon[weapon_name(weapon)]]
            if pool == NO_POOL:
                raise ValueError(f"it carries no {weapon}")
            piece.ammo[pool] = _whole(rounds, MAX_AMMO)

    def set_aboard(self, name: str, value: Value) -> None:
        """Put a soldier into a chariot of its camp ("chariot0"), or None: into the chariot's cell."""
        i, piece = self._piece(name)
        if piece.kind != PieceType.SOLDIER:
            raise ValueError("only soldiers ride")
        pieces = self._state.pieces[0]
        if piece.carrier != NO_PIECE:
            pieces[piece.carrier].passenger = NO_PIECE
            piece.carrier = NO_PIECE
        if value is None:
            return
        c = self.roster.own_index(piece.camp, value)
        if pieces[c].kind != PieceType.CHARIOT or pieces[c].passenger != NO_PIECE:
            raise ValueError("expected a chariot with room")
        self.set_path(name, [])
        piece.carrier, piece.cell, pieces[c].passenger = c, pieces[c].cell, i

    def set_owner(self, name: str, value: Value) -> None:
        """Give a control point to "red", "blue" or "green"."""
        owner = Camp.GREEN if value == camp_name(Camp.GREEN) else parse_camp(value)
        self._state.games[0].point_owner[self.roster.point_index(name)] = owner

    def _end(self, ticks: int) -> int:
        return int(self._state.games[0].tick) + ticks if ticks else NEVER


Writer: TypeAlias = Callable[[Editor, str, Value], None]

_PIECE_FIELDS: dict[str, Writer] = {
    "cell": Editor.set_cell,
    "path": Editor.set_path,
    "blood": Editor.set_blood,
    "hidden": Editor.set_hidden,
    "suppressed": Editor.set_suppressed,
    "cool": Editor.set_cool,
    "mortar_cool": Editor.set_mortar_cool,
    "stopping": Editor.set_stopping,
    "ammo": Editor.set_ammo,
    "aboard": Editor.set_aboard,
}
_SHOWN_AS = {  # field of a view that shows a field of an edit
    "suppressed": "suppressed_left",
    "cool": "cool_left",
    "mortar_cool": "mortar_cool_left",
    "stopping": "stop_left",
}
_POINT_FIELDS: dict[str, Writer] = {"owner": Editor.set_owner}


class Entry:
    """One piece or control point under edit: assign to its fields."""

    def __init__(self, editor: Editor, name: str, fields: dict[str, Writer]) -> None:
        object.__setattr__(self, "_editor", editor)
        object.__setattr__(self, "_name", name)
        object.__setattr__(self, "_fields", fields)

    def field(self, name: str) -> Writer:
        """What writes a field.

        Raises:
            ConfigError: no such field.
        """
        fields = cast("dict[str, Writer]", self._fields)
        if name not in fields:
            known = ", ".join(fields)
            hint = did_you_mean(name, fields)
            raise ConfigError(f"{self._name} has no field {name!r}{hint}; fields: {known}")
        return fields[name]

    def __setattr__(self, name: str, value: Value) -> None:
        self._editor.apply((self._name, name, value))

    def __getattr__(self, name: str) -> Value:
        self.field(name)
        return self._editor.read(self._name, name)


def _whole(value: Value, most: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise ValueError(f"expected a whole number from 0 to {most}")
    return value
