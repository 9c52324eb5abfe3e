"""What one camp may know, and nothing else (rule book, section 6).

A field that the camp does not know is absent from the class, not zero. An enemy is seen now
(`SeenEnemy`), remembered (`LostEnemy`), or has never been seen (`UnseenEnemy`).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields, is_dataclass
from typing import Any

from hexwar_sb3.engine.pieces import next_cell_of
from hexwar_sb3.engine.reasons import doing, kind_name
from hexwar_sb3.engine.records import (
    NEVER,
    NO_CELL,
    NO_PIECE,
    ROUND_BURSTING,
    ROUND_FLYING,
    ROUND_FREE,
)
from hexwar_sb3.engine.roster import Roster, camp_name, enemy_of
from hexwar_sb3.engine.score import known_margin, own_total
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.kernels import Row
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.records import plain
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import Weapon
from hexwar_sb3.rules.indices import CampIndex


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnPiece:
    """A piece of the camp, in full. Timers are ticks left, 0 when they do not run."""

    name: str
    kind: str
    cell: str
    blood: int
    alive: bool
    doing: str  # "settled", "moving", "stopping", "hiding", ...
    path: tuple[str, ...]  # cells still to walk
    hop_left: int  # of the hop under way
    speed: float  # cells a tick
    ammo: tuple[tuple[str, int], ...]  # weapon, rounds; weapons of one pool share them
    hidden: bool
    suppressed: bool
    suppressed_left: int
    cool_left: int
    mortar_cool_left: int
    stop_left: int
    hide_left: int
    board_left: int
    decompress_left: int
    aboard: str | None  # the chariot that carries it
    passenger: str | None
    sees: tuple[str, ...]  # enemies that this piece itself sees

    def __str__(self) -> str:
        """One line: "tank0 1134, blood 3, moving to 1434; 10 GUN"."""
        if not self.alive:
            return f"{self.name} is destroyed"
        place = f"aboard {self.aboard}" if self.aboard else self.cell
        doing = f"moving to {self.path[-1]}" if self.path else self.doing
        states = [word for word in ("hidden", "suppressed") if getattr(self, word) and word not in doing]
        carried = [f"with {self.passenger} aboard"] if self.passenger else []
        sees = [f"sees {', '.join(self.sees)}"] if self.sees else []
        rounds = ", ".join(f"{left} {weapon}" for weapon, left in self.ammo)
        return ", ".join([f"{self.name} {place}", f"blood {self.blood}", doing, *states, *carried, *sees]) + (
            f"; {rounds}" if rounds else ""
        )

    @property
    def cold_down(self) -> int:
        """The longest of the running timers (II-A: one cool-down property)."""
        return max(
            self.suppressed_left, self.cool_left, self.mortar_cool_left, self.stop_left,
            self.hide_left, self.board_left, self.decompress_left,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenEnemy:
    """An enemy piece that some own piece sees now."""

    name: str
    kind: str
    cell: str
    next_cell: str | None  # where its hop under way leads
    blood: int
    hidden: bool
    suppressed: bool
    moving: bool
    speed: float  # cells a tick
    seen_since: int  # tick

    def __str__(self) -> str:
        """One line: "blue:tank0 seen in 2010, blood 2, moving to 2011"."""
        going = [f"moving to {self.next_cell}"] if self.next_cell else []
        states = [word for word in ("hidden", "suppressed") if getattr(self, word)]
        return ", ".join([f"{self.name} seen in {self.cell}", f"blood {self.blood}", *going, *states])


@dataclass(frozen=True, slots=True, kw_only=True)
class LostEnemy:
    """An enemy piece as it was last seen; u(sigma, t) of III-A. Blood 0: seen to be destroyed."""

    name: str
    kind: str
    cell: str
    blood: int
    unseen_ticks: int

    def __str__(self) -> str:
        """One line: "blue:tank0 last seen in 2010, 40 ticks ago, blood 2"."""
        if self.blood == 0:
            return f"{self.name} was seen to be destroyed"
        return f"{self.name} last seen in {self.cell}, {self.unseen_ticks} ticks ago, blood {self.blood}"


@dataclass(frozen=True, slots=True, kw_only=True)
class UnseenEnemy:
    """An enemy piece that was never seen; the order of battle is known."""

    name: str
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PointView:
    """A control point."""

    name: str
    cell: str
    value: int
    owner: str  # "red", "blue" or "green"


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundView:
    """An own mortar round."""

    owner: str
    aimed_at: str
    fired_at: int
    lands_in: int  # ticks; 0 after landing
    bursting: bool


@dataclass(frozen=True, kw_only=True)
class SideView:
    """All that one camp may know in one state; equal knowledge gives equal views.

    Example:
        >>> view = Game("plain", seed=0).view("red")
        >>> print(view.piece("tank0"))
        tank0 1135, blood 3, settled; 30 GUN, 30 LIGHT
        >>> view.seen  # no enemy yet
        ()
    """

    camp: str
    tick: int
    ticks_left: int
    over: bool
    own: tuple[OwnPiece, ...]
    seen: tuple[SeenEnemy, ...]
    lost: tuple[LostEnemy, ...]
    unseen: tuple[UnseenEnemy, ...]
    points: tuple[PointView, ...]
    rounds: tuple[RoundView, ...]
    bursting: tuple[str, ...]  # cells under a burst of either camp
    fights: tuple[str, ...]  # cells of close combats
    own_total: int
    known_margin: int  # enemies count at their last seen blood
    hexmap: HexMap = field(repr=False, compare=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for a file, without the map."""
        names = (entry.name for entry in fields(self) if entry.compare)
        return {name: _plain(getattr(self, name)) for name in names}

    def __str__(self) -> str:
        """What a person wants to read first; all of it is in the fields."""
        points = ", ".join(f"{point.name} {point.cell} {point.owner}" for point in self.points)
        margin = f"own {self.own_total}, margin as known {self.known_margin:+}"
        lines = [
            f"{self.camp}, tick {self.tick} of {self.tick + self.ticks_left}: {margin}; {points or 'no points'}",
            *(f"  {piece}" for piece in self.own),
            *(f"  {enemy}" for enemy in (*self.seen, *self.lost)),
        ]
        if self.unseen:
            lines.append("  never seen: " + ", ".join(enemy.name for enemy in self.unseen))
        for name in ("fights", "bursting"):
            if getattr(self, name):
                lines.append(f"  {name} in " + ", ".join(getattr(self, name)))
        return "\n".join(lines)

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """In notebooks."""
        printer.text(str(self))

    def piece(self, name: str) -> OwnPiece:
        """An own piece by its name.

        Raises:
            UnknownNameError: the camp has no such piece.
        """
        pieces = {piece.name: piece for piece in self.own}
        if name not in pieces:
            raise UnknownNameError("piece", name, pieces)
        return pieces[name]


def side_view(camp: CampIndex, state: State, b: int, world: World) -> SideView:
    """The view of a camp of game b."""
    return _Viewer(camp, state, b, world).view()


def known_now(camp: CampIndex, state: State, b: int, world: World) -> dict[str, Any]:
    """What changes in a camp's view of game b, as short as a replay has it; the camp's own timers apart.

    Returns:
        `pieces`, a list [name, cell, blood, hidden, suppressed, carrier, seen] for each that is not unseen, what the
        camp does not know as None; `owners` of the control points, `known_margin`, cells `bursting` and `fights`.
    """
    return _Viewer(camp, state, b, world).known_now()


_WEAPONS = tuple(weapon.name for weapon in Weapon)


class _Viewer:
    """Reads one game for one camp."""

    def __init__(self, camp: CampIndex, state: State, b: int, world: World) -> None:
        self.camp, self.world = camp, world
        self.game = state.games[b]
        self.tick = int(self.game.tick)
        self.rows, self.all_known = state.pieces[b], state.memory[b]  # as kernels read them
        self.pieces, self.known = plain(self.rows), plain(self.all_known[camp])
        self.paths, self.rounds = state.paths[b], plain(state.rounds[b])
        self.pools = world.rules.pool[0].tolist()  # [kind][weapon]
        self.roster = Roster(world.scenario)
        self.own = self.roster.pieces_of(camp)
        self.enemies = self.roster.pieces_of(enemy_of(camp))

    def view(self) -> SideView:
        game, rules = self.game, self.world.rules[0]
        return SideView(
            camp=camp_name(self.camp),
            tick=self.tick,
            ticks_left=int(game.end_tick) - self.tick,
            over=bool(game.over),
            own=tuple(self._own(i) for i in self.own),
            seen=tuple(self._seen(i) for i in self.enemies if self.known[i].seen),
            lost=tuple(
                self._lost(i) for i in self.enemies if not (self.known[i].seen or self._never_seen(i))
            ),
            unseen=tuple(self._unseen(i) for i in self.enemies if self._never_seen(i)),
            points=tuple(self._point(k) for k in range(game.n_points)),
            rounds=tuple(self._round(r) for r in self.rounds if self._is_own_round(r)),
            bursting=self._bursting(),
            fights=self._fights(),
            own_total=int(own_total(game, self.rows, self.camp, rules)),
            known_margin=int(known_margin(game, self.rows, self.all_known, self.camp, rules)),
            hexmap=self.world.scenario.hexmap,
        )

    def known_now(self) -> dict[str, Any]:
        game, rules = self.game, self.world.rules[0]
        own = [self._own_now(i) for i in self.own]
        enemies = [self._enemy_now(i) for i in self.enemies if not self._never_seen(i)]
        return {
            "pieces": [*own, *enemies],
            "owners": [camp_name(owner) for owner in game.point_owner[: game.n_points]],
            "known_margin": int(known_margin(game, self.rows, self.all_known, self.camp, rules)),
            "bursting": list(self._bursting()),
            "fights": list(self._fights()),
        }

    def _own_now(self, i: int) -> list[Any]:
        piece = self.pieces[i]
        states = int(piece.blood), int(piece.hidden), int(piece.suppressed)
        return [self.roster.names[i], self._cell(piece.cell), *states, self._name(piece.carrier), 1]

    def _enemy_now(self, i: int) -> list[Any]:
        piece, known = self.pieces[i], self.known[i]
        if known.seen:
            states = int(piece.blood), int(piece.hidden), int(piece.suppressed)
            return [self.roster.names[i], self._cell(piece.cell), *states, None, 1]
        return [self.roster.names[i], self._cell(known.cell), int(known.blood), None, None, None, 0]

    def _own(self, i: int) -> OwnPiece:
        piece = self.pieces[i]
        return OwnPiece(
            name=self.roster.short(i),
            kind=kind_name(piece.kind),
            cell=self._cell(piece.cell),
            blood=int(piece.blood),
            alive=bool(piece.blood > 0),
            doing=doing(piece),
            path=tuple(self._path(i)),
            hop_left=self._left(piece.arrives_at),
            speed=_speed(piece),
            ammo=tuple(self._ammo(piece)),
            hidden=bool(piece.hidden),
            suppressed=bool(piece.suppressed),
            suppressed_left=self._left(piece.keep_ends),
            cool_left=self._left(piece.cool_ends),
            mortar_cool_left=self._left(piece.mortar_ends),
            stop_left=self._left(piece.stop_ends),
            hide_left=self._left(piece.hide_ends),
            board_left=self._left(piece.board_ends),
            decompress_left=self._left(piece.decompress_ends),
            aboard=self._name(piece.carrier),
            passenger=self._name(piece.passenger),
            sees=tuple(self.roster.names[j] for j in self.enemies if piece.sees >> self.pieces[j].slot & 1),
        )

    def _seen(self, i: int) -> SeenEnemy:
        piece = self.pieces[i]
        next_cell = next_cell_of(self.rows[i], self.paths[i], self.world.cells)
        return SeenEnemy(
            name=self.roster.names[i],
            kind=kind_name(piece.kind),
            cell=self._cell(piece.cell),
            next_cell=None if next_cell == NO_CELL else self._cell(next_cell),
            blood=int(piece.blood),
            hidden=bool(piece.hidden),
            suppressed=bool(piece.suppressed),
            moving=_has_path(piece) or piece.stop_ends != NEVER,
            speed=_speed(piece),
            seen_since=self.known[i].first_tick,
        )

    def _lost(self, i: int) -> LostEnemy:
        known = self.known[i]
        return LostEnemy(
            name=self.roster.names[i],
            kind=kind_name(self.pieces[i].kind),
            cell=self._cell(known.cell),
            blood=int(known.blood),
            unseen_ticks=self.tick - known.tick,
        )

    def _unseen(self, i: int) -> UnseenEnemy:
        return UnseenEnemy(name=self.roster.names[i], kind=kind_name(self.pieces[i].kind))

    def _never_seen(self, i: int) -> bool:
        return bool(self.known[i].cell == NO_CELL)

    def _path(self, i: int) -> list[str]:
        piece = self.pieces[i]
        if not _has_path(piece):
            return []
        names, here, neighbour = [], piece.cell, self.world.cells.neighbour
        for direction in self.paths[i, piece.path_pos : piece.path_len].tolist():
            here = neighbour[here, direction]
            names.append(self._cell(here))
        return names

    def _ammo(self, piece: Row) -> list[tuple[str, int]]:
        ammo, pools = piece.ammo.tolist(), self.pools[piece.kind]
        return [(name, ammo[pool]) for name, pool in zip(_WEAPONS, pools, strict=True) if pool != NO_POOL]

    def _point(self, k: int) -> PointView:
        point = self.world.scenario.points[k]
        owner = camp_name(self.game.point_owner[k])
        return PointView(name=point.name, cell=self._cell(point.cell), value=point.value, owner=owner)

    def _is_own_round(self, shell: Row) -> bool:
        return bool(shell.camp == self.camp and shell.status != ROUND_FREE)

    def _round(self, shell: Row) -> RoundView:
        return RoundView(
            owner=self.roster.short(shell.owner),
            aimed_at=self._cell(shell.cell),
            fired_at=int(shell.fired_at),
            lands_in=self._left(shell.land_at) if shell.status == ROUND_FLYING else 0,
            bursting=bool(shell.status == ROUND_BURSTING),
        )

    def _bursting(self) -> tuple[str, ...]:
        bursts = {self._cell(r.impact) for r in self.rounds if r.status == ROUND_BURSTING}
        return tuple(sorted(bursts))

    def _fights(self) -> tuple[str, ...]:
        return tuple(sorted(self._cell(c) for c in self.game.fight_cell if c != NO_CELL))

    def _left(self, ends: int) -> int:
        return 0 if ends == NEVER else max(0, ends - self.tick)

    def _cell(self, cell: int) -> str:
        return self.roster.cell_name(cell)

    def _name(self, i: int) -> str | None:
        return None if i == NO_PIECE else self.roster.short(i)


def _has_path(piece: Row) -> bool:
    """As `pieces.has_path`, of a record that is a tuple."""
    return bool(piece.path_pos < piece.path_len)


def _speed(piece: Row) -> float:
    """Cells a tick while hopping, 0 otherwise."""
    hopping = _has_path(piece) and piece.arrives_at != NEVER
    return 1.0 / piece.hop_need if hopping else 0.0


def _plain(value: object) -> object:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value
