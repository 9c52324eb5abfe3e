"""What happened in a step, in names instead of indices: `Game.advance` returns these."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.enums import Weapon

_SHOTS = {Event.SHOT, Event.GUIDED, Event.CLOSE_SHOT, Event.EXIT_SHOT, Event.MORTAR_JUDGED}
_BY_ROUND = {Event.MORTAR_LANDED, Event.MORTAR_JUDGED}


@dataclass(frozen=True, slots=True, kw_only=True)
class GameEvent:
    """One event; what an event of its kind does not have is None."""

    tick: int  # of the state that it made
    kind: str  # "shot", "guided", "dead", ...
    piece: str  # who did it or whom it befell: "red:tank0"
    cell: str | None = None
    target: str | None = None  # shot at; or the partner of a boarding
    shooter: str | None = None  # the chariot that launched a guided missile
    weapon: str | None = None
    level: int | None = None  # attack level
    cells_apart: int | None = None
    roll: int | None = None  # two dice
    raw: int | None = None  # result of the roll
    correction_roll: int | None = None
    modifiers: int | None = None
    correction: int | None = None
    result: int | None = None  # -1 nothing, 0 suppressed, n losses
    losses: int | None = None
    hit: bool | None = None  # a round came down on target
    order: str | None = None  # refused
    reason: str | None = None  # why it was refused

    def as_dict(self) -> dict[str, Any]:
        """The fields that the event has."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}

    def __str__(self) -> str:
        parts = [f"tick {self.tick}: {self.piece} {self.kind.replace('_', ' ')}"]
        skipped = {"tick", "piece", "kind"}
        parts += [f"{k} {v}" for k, v in self.as_dict().items() if k not in skipped]
        return ", ".join(parts)


def read_events(game: Row, log: Rows, roster: Roster) -> list[GameEvent]:
    """The events that the engine logged since `log_count` was set to 0."""
    return [_read(row, roster) for row in log[: game.log_count]]


def _read(row: Row, roster: Roster) -> GameEvent:
    event = Event(row.event)
    fields: dict[str, Any] = {"tick": int(row.tick), "kind": event.name.lower()}
    fields["piece"] = roster.names[row.a]
    if row.b != NO_PIECE:
        fields["target"] = roster.names[row.b]
    if row.cell != NO_CELL:
        fields["cell"] = roster.cell_name(row.cell)
    if event in _SHOTS:
        fields |= _dice(row)
    if event is Event.GUIDED:
        fields["shooter"] = roster.names[row.extra]
    if event is Event.LOSS:
        fields["losses"] = int(row.extra)
    if event in _BY_ROUND:
        fields["hit"] = bool(row.extra)
    return GameEvent(**fields)


def _dice(row: Row) -> dict[str, Any]:
    return {
        "weapon": Weapon(row.weapon).name,
        "level": int(row.level),
        "cells_apart": int(row.cells_apart),
        "roll": int(row.roll),
        "raw": int(row.raw),
        "correction_roll": int(row.roll2),
        "modifiers": int(row.mods),
        "correction": int(row.corr),
        "result": int(row.result),
    }


def of_kind(events: Iterable[GameEvent], *kinds: str) -> list[GameEvent]:
    """The events of some kinds."""
    return [event for event in events if event.kind in kinds]
