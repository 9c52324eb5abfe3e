"""A rule set: the tables of tables.py checked, hashed and compiled.

Another rule set is another instance: `default_rules().with_rows(replace(row, ...))`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property, lru_cache
from typing import TypeAlias, TypeVar, cast

import numpy as np

from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.rules import tables
from hexwar_sb3.rules.check import check_rules
from hexwar_sb3.rules.compiled import RULES
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.fill import fill_record
from hexwar_sb3.rules.odds import fill_odds
from hexwar_sb3.rules.rows import AttackRow, Key, Number, PieceRow, RuleTables, Table, WeaponRow, named

Row: TypeAlias = PieceRow | WeaponRow | AttackRow | Number | Table
Entry = TypeVar("Entry", bound=Row)

_NOT_RULES = frozenset({"version", "unit", "source"})  # words: outside the hash


@dataclass(frozen=True, kw_only=True)
class RuleSet(RuleTables):
    """All numbers of one game; equal hashes mean equal rules.

    Raises:
        ConfigError: a row is missing, of the wrong shape or out of its range.
    """

    def __post_init__(self) -> None:
        check_rules(self)

    @cached_property
    def hash(self) -> str:
        """Sha256 over every number, the same on every machine; units and sources do not count."""
        text = json.dumps(_plain(self), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    def compiled(self) -> np.recarray:
        """A new record [1] of `compiled.RULES`, the form that kernels read."""
        rules = np.zeros(1, RULES).view(np.recarray)
        fill_record(rules[0], self)
        fill_odds(rules[0])
        return rules

    def with_rows(self, *rows: Row) -> RuleSet:
        """These rules with some rows replaced by rows of the same piece, weapon or name."""
        changed = {row.key: row for row in rows}
        unknown = changed.keys() - set(self._keys())
        if unknown:
            raise ConfigError(f"these rules have no row {min(map(str, unknown))} to replace")
        return replace(
            self,
            pieces=_replaced(self.pieces, changed),
            weapons=_replaced(self.weapons, changed),
            attacks=_replaced(self.attacks, changed),
            numbers=_replaced(self.numbers, changed),
            tables=_replaced(self.tables, changed),
        )

    def with_numbers(self, **values: int) -> RuleSet:
        """These rules with some numbers changed, as in `with_numbers(stop_ticks=50)`."""
        rows = [replace(named(self.numbers, name), value=n) for name, n in values.items()]
        return self.with_rows(*rows)

    def with_aerocraft(self, name: str) -> RuleSet:
        """These rules with another aerocraft: "default", "uav" or "heli"."""
        if name not in tables.AEROCRAFT:
            raise UnknownNameError("aerocraft profile", name, tables.AEROCRAFT)
        profile = tables.AEROCRAFT[name]
        row = replace(self.pieces[PieceType.AEROCRAFT], base_hop=profile.base_hop)
        return replace(self, aerocraft=profile, pieces=_replaced(self.pieces, {row.key: row}))

    def _keys(self) -> Iterator[Key]:
        for group in (self.pieces, self.weapons, self.attacks, self.numbers, self.tables):
            yield from (row.key for row in cast("Sequence[Row]", group))


def _replaced(rows: tuple[Entry, ...], changed: dict[Key, Row]) -> tuple[Entry, ...]:
    return tuple(cast("Entry", changed.get(row.key, row)) for row in rows)


def _plain(value: object) -> object:
    """Rows as dicts and lists, without the words that are no rules."""
    if is_dataclass(value):
        names = (field.name for field in fields(value) if field.name not in _NOT_RULES)
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


@lru_cache(maxsize=1)
def default_rules() -> RuleSet:
    """The rule book as it stands in tables.py."""
    return RuleSet(
        version=tables.VERSION,
        pieces=tables.PIECES,
        weapons=tables.WEAPONS,
        attacks=tables.ATTACKS,
        ground_sight=tables.GROUND_SIGHT,
        aerocraft=tables.AEROCRAFT["default"],
        numbers=tables.NUMBERS,
        tables=tables.TABLES,
    )
