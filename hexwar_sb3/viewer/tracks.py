"""Change lists of what one camp knows: its own pieces in full, and what it believes of the enemy's.

They are made of `SideView`s and of nothing else, so they hold nothing that the camp does not know. A list of changes
is `[tick, value, tick, value, ...]`: each value holds from its tick to the next. Cells are numbers, as in the records.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.engine.view import LostEnemy, OwnPiece, SeenEnemy, SideView
from hexwar_sb3.maps.hexmap import HexMap

NEVER_SEEN, SEEN, LOST = 0, 1, 2
NOWHERE = -1  # no cell, no piece
_TIMERS = ("suppressed", "cool", "mortar_cool", "stop", "hide", "board", "decompress")
_USUAL = ([0, 0], [0, []], [0, NOWHERE])
Json = dict[str, Any]


class Changes(list[Any]):
    """Values with the ticks from which on they hold, in one flat list."""

    def note(self, tick: int, value: Any) -> None:
        """The value at this tick, written if it is another one than before."""
        if not self or self[-1] != value:
            self += [tick, value]


class Track(dict[str, Changes]):
    """Changes of several fields by name."""

    def note(self, tick: int, values: Mapping[str, Any]) -> None:
        """The values at this tick."""
        for name, value in values.items():
            self.setdefault(name, Changes()).note(tick, value)

    def told(self) -> Json:
        """The fields that are not 0, nothing or nobody all the time."""
        return {name: changes for name, changes in self.items() if changes not in _USUAL}


class OwnTrack:
    """What is told of an own piece. Where it stands follows from its hops; `cell` has what they do not explain."""

    def __init__(self, camp: str, roster: Roster) -> None:
        self.camp, self.roster = camp, roster
        self.fields = Track()
        self.hops: list[list[int]] = []  # [start, end, cell], and where it was broken off the tick
        self._cell = NOWHERE  # as the reader will have it
        self._read = 0  # hops that the reader has seen to their ends

    def note(self, tick: int, piece: OwnPiece) -> None:
        """The piece at this tick."""
        hexmap = self.roster.scenario.hexmap
        path = [hexmap.parse_cell(cell) for cell in piece.path]
        self._note_hop(tick, piece, path)
        self._note_cell(tick, hexmap.parse_cell(piece.cell))
        values: Json = {
            "blood": piece.blood,
            "hidden": int(piece.hidden),
            "suppressed": int(piece.suppressed),
            "then": path[1:] if piece.hop_left else path,  # the cells after the hop under way
            "ammo": [left for _, left in piece.ammo],
            "carrier": NOWHERE if piece.aboard is None else self.roster.index(f"{self.camp}:{piece.aboard}"),
            "sees": [self.roster.index(name) for name in piece.sees],
        }
        self.fields.note(tick, values | {f"{name}_ends": _end(tick, piece, name) for name in _TIMERS})

    def _note_hop(self, tick: int, piece: OwnPiece, path: Sequence[int]) -> None:
        end = tick + piece.hop_left if piece.hop_left else 0
        under_way = self.hops[-1] if self.hops and self.hops[-1][1] > tick else None
        if under_way is not None and len(under_way) == 3 and under_way[1:] != [end, *path[:1]]:
            under_way.append(tick)
        if end and (not self.hops or self.hops[-1][1:] != [end, path[0]]):
            self.hops.append([end - round(1 / piece.speed), end, path[0]])

    def _note_cell(self, tick: int, cell: int) -> None:
        for hop in self.hops[self._read :]:
            if hop[1] > tick and len(hop) == 3:
                break
            self._read += 1
            self._cell = hop[2] if len(hop) == 3 else self._cell
        if cell != self._cell:
            self.fields.setdefault("cell", Changes()).extend([tick, cell])
            self._cell = cell

    def told(self) -> Json:
        """As it stands in a story."""
        return self.fields.told() | {"hops": self.hops}


class BeliefTrack:
    """What a camp believes of an enemy piece: as it sees it, or as it last saw it."""

    def __init__(self) -> None:
        self.fields = Track()

    def note_seen(self, tick: int, enemy: SeenEnemy, hexmap: HexMap) -> None:
        """It is in sight."""
        next_cell = NOWHERE if enemy.next_cell is None else hexmap.parse_cell(enemy.next_cell)
        known = {
            "hidden": int(enemy.hidden),
            "suppressed": int(enemy.suppressed),
            "moving": int(enemy.moving),
        }
        where = {"cell": hexmap.parse_cell(enemy.cell), "blood": enemy.blood}
        self.fields.note(tick, {"state": SEEN, "next": next_cell, **where, **known})

    def note_lost(self, tick: int, enemy: LostEnemy, hexmap: HexMap) -> None:
        """It was in sight."""
        where = {"cell": hexmap.parse_cell(enemy.cell), "blood": enemy.blood, "next": NOWHERE}
        self.fields.note(tick, {"state": LOST, "last": tick - enemy.unseen_ticks, **where})

    def note_unseen(self, tick: int) -> None:
        """It never was."""
        self.fields.note(tick, {"state": NEVER_SEEN})

    def told(self) -> Json:
        """As it stands in a story; a piece that was never seen has nothing."""
        return self.fields.told()


class CampTracks:
    """All that one camp knows of a game, gathered view by view."""

    def __init__(self, camp: str, roster: Roster) -> None:
        self.camp, self.roster = camp, roster
        self.own = {name: OwnTrack(camp, roster) for name in roster.names if name.startswith(camp)}
        self.beliefs = {name: BeliefTrack() for name in roster.names if name not in self.own}
        self.owners = [Changes() for _ in roster.scenario.points]
        self.known_margin, self.own_total, self.fights, self.bursts = (
            Changes(),
            Changes(),
            Changes(),
            Changes(),
        )
        self.rounds: dict[tuple[str, int], list[int]] = {}

    def note(self, view: SideView) -> None:
        """What the camp knows at one tick more."""
        tick, hexmap = view.tick, view.hexmap
        for piece in view.own:
            self.own[f"{self.camp}:{piece.name}"].note(tick, piece)
        for seen in view.seen:
            self.beliefs[seen.name].note_seen(tick, seen, hexmap)
        for lost in view.lost:
            self.beliefs[lost.name].note_lost(tick, lost, hexmap)
        for unseen in view.unseen:
            self.beliefs[unseen.name].note_unseen(tick)
        for changes, point in zip(self.owners, view.points, strict=True):
            changes.note(tick, point.owner)
        self.known_margin.note(tick, view.known_margin)
        self.own_total.note(tick, view.own_total)
        self.fights.note(tick, [hexmap.parse_cell(cell) for cell in view.fights])
        self.bursts.note(tick, [hexmap.parse_cell(cell) for cell in view.bursting])
        self._note_rounds(view)

    def _note_rounds(self, view: SideView) -> None:
        for shell in view.rounds:
            owner = self.roster.index(f"{self.camp}:{shell.owner}")
            lands = view.tick + shell.lands_in
            row = [owner, view.hexmap.parse_cell(shell.aimed_at), shell.fired_at, lands]
            self.rounds.setdefault((shell.owner, shell.fired_at), row)
        there = {(shell.owner, shell.fired_at) for shell in view.rounds}
        for key, row in self.rounds.items():
            if key not in there and len(row) == 4 and row[3] > view.tick:
                row.append(view.tick)  # called off by a move of its owner, or lost with it


def _end(tick: int, piece: OwnPiece, timer: str) -> int:
    """Tick at which a timer runs out; 0 where none runs."""
    left: int = getattr(piece, f"{timer}_left")
    return tick + left if left else 0
