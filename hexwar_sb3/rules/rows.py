"""The forms of a row in the rule tables. No numbers here: those stand in tables.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar, cast

from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.rules.compiled import NO_EFFECT, SCATTER_HIT
from hexwar_sb3.rules.enums import PieceType, TargetClass, Weapon

Cells: TypeAlias = "int | tuple[Cells, ...]"
Key: TypeAlias = tuple[object, ...]

SIGNS = {".": NO_EFFECT, "S": 0, "s": 0, "H": SCATTER_HIT}
"""How the rule book writes: no effect; suppression; in the cell but off target; hit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pool:
    """Ammunition that one or more weapons of a piece share."""

    weapons: tuple[Weapon, ...]
    ammo: int  # rounds at the start
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceRow:
    """Intrinsic properties of a piece type (II-A, Fig. 2)."""

    kind: PieceType
    value: int  # points per unit of blood; v_p in eq. (1)
    blood: int  # vehicles or squads at the start; n_p in eq. (1)
    armour: int  # 0 none, 1 light, 2 medium, 3 heavy, 4 composite
    base_hop: int  # ticks per cell on open ground
    moving_fire: bool  # may fire its moving weapon while under way
    pools: tuple[Pool, ...]
    source: str

    @property
    def key(self) -> Key:
        """What makes a row one of a kind."""
        return ("piece", self.kind)


@dataclass(frozen=True, slots=True, kw_only=True)
class WeaponRow:
    """A weapon and the code that the public platform gives it."""

    weapon: Weapon
    code: int
    source: str

    @property
    def key(self) -> Key:
        """What makes a row one of a kind."""
        return ("weapon", self.weapon)


@dataclass(frozen=True, slots=True, kw_only=True)
class AttackRow:
    """Attack levels of one weapon against one class of targets."""

    weapon: Weapon
    target: TargetClass
    first_cells: int  # distance of the first column
    levels: tuple[tuple[int, ...], ...]  # [shooter blood from 1; distance]; one row: any blood
    source: str

    @property
    def key(self) -> Key:
        """What makes a row one of a kind."""
        return ("attack", self.weapon, self.target)

    def of_blood(self, blood: int) -> tuple[int, ...]:
        """Levels by distance; a piece with more blood than the table has rows reads the last."""
        return self.levels[min(blood, len(self.levels)) - 1]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundSight:
    """How far a ground piece sees ground pieces."""

    soldier_cells: int
    vehicle_cells: int
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AerocraftProfile:
    """How fast an aerocraft is, how far it sees and from how far it is seen."""

    name: str
    base_hop: int  # ticks per cell
    soldier_cells: int
    vehicle_cells: int
    seen_cells: int  # by every observer
    source: str


@dataclass(frozen=True, slots=True)
class Number:
    """One number of the rules; `name` is its field in the compiled record."""

    name: str
    value: int
    unit: str
    source: str

    @property
    def key(self) -> Key:
        """What makes a row one of a kind."""
        return ("number", self.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of the rule book, read with the rule book's own numbers: `table.at(roll, column)`."""

    name: str  # its field in the compiled record
    first: tuple[int, ...]  # number of the first row, first column, ...
    cells: Cells
    unit: str
    source: str

    @property
    def key(self) -> Key:
        """What makes a row one of a kind."""
        return ("table", self.name)

    def at(self, *index: int) -> int:
        """One entry, by the numbers that the rule book gives to rows and columns."""
        cells = self.cells
        for number, first in zip(index, self.first, strict=True):
            inside = isinstance(cells, tuple) and 0 <= number - first < len(cells)
            if not inside:
                raise ConfigError(f"table {self.name} has no entry {index}")
            cells = cast("tuple[Cells, ...]", cells)[number - first]
        return cast("int", cells)

    def clamped(self, row: int, *rest: int) -> int:
        """Entry of the nearest row: the outermost rows stand for everything beyond them."""
        last = self.first[0] + len(cast("tuple[Cells, ...]", self.cells)) - 1
        return self.at(min(max(row, self.first[0]), last), *rest)


Named = TypeVar("Named", Number, Table)


@dataclass(frozen=True, kw_only=True)
class RuleTables:
    """All rows of one game."""

    version: str
    pieces: tuple[PieceRow, ...]  # [PieceType]
    weapons: tuple[WeaponRow, ...]  # [Weapon]
    attacks: tuple[AttackRow, ...]
    ground_sight: GroundSight
    aerocraft: AerocraftProfile
    numbers: tuple[Number, ...]
    tables: tuple[Table, ...]

    def number(self, name: str) -> int:
        """One number by the name that it has in the compiled record."""
        return named(self.numbers, name).value

    def table(self, name: str) -> Table:
        """One table by the name that it has in the compiled record."""
        return named(self.tables, name)


def named(rows: Sequence[Named], name: str) -> Named:
    """Find a row by its name.

    Raises:
        UnknownNameError: no row has it.
    """
    for row in rows:
        if row.name == name:
            return row
    raise UnknownNameError("rule", name, (row.name for row in rows))


def numbers(text: str) -> tuple[int, ...]:
    """Read "1 . S 2" as the rule book writes it (`SIGNS`)."""
    return tuple(SIGNS[sign] if sign in SIGNS else int(sign) for sign in text.split())


def lines(text: str) -> tuple[tuple[int, ...], ...]:
    """One row of numbers for each line that is not empty."""
    return tuple(numbers(line) for line in text.splitlines() if line.strip())


def numbered(text: str, first: int) -> tuple[tuple[int, ...], ...]:
    """Rows that begin with their own number, as in "2: 1 . S"; they count up from `first`."""
    pairs = [line.split(":") for line in text.splitlines() if line.strip()]
    for due, (label, _) in enumerate(pairs, start=first):
        if int(label) != due:
            raise ConfigError(f"a rule table has row {label.strip()} where row {due} is due")
    return tuple(numbers(row) for _, row in pairs)
