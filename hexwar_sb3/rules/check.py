"""Is a rule set complete, and within what the record and the kernels can hold?"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules.compiled import LEAST_MODIFIER, MOST_MODIFIER, RULES
from hexwar_sb3.rules.enums import PieceType, Weapon
from hexwar_sb3.rules.rows import AttackRow, Number, PieceRow, RuleTables, Table

MAX_BLOOD = RULES["column"].shape[0] - 1
MAX_LEVEL = RULES["column"].shape[1] - 1
MAX_COLUMN = RULES["vehicle_result"].shape[1] - 1
MAX_ARMOUR = RULES["burst_armour"].shape[0] - 1
MAX_POOLS = RULES["pool_ammo"].shape[1]
MAX_CELLS = RULES["level"].shape[3] - 1
MAX_VALUE = 1000
MAX_HOP = 255
MAX_BYTE = 127

TABLE_LIMITS = {
    "column": (1, MAX_COLUMN),
    "vehicle_result": (-1, 5),
    "soldier_result": (-1, 5),
    "vehicle_correction": (-3, 3),
    "soldier_correction": (-3, 3),
    "height": (-MAX_LEVEL, 0),
    "scatter": (-1, MAX_CELLS),
}
"""What other code counts on, the odds above all; the other tables only have to fit a byte."""

FROM_ROWS = frozenset(
    {"value", "blood", "armour", "base_hop", "moving_fire", "pool", "pool_ammo", "sight", "level"}
)
DERIVED = frozenset({"odds_vehicle", "odds_small", "odds_soldier", "odds_air"})


def check_rules(rules: RuleTables) -> None:
    """Raise ConfigError at the first row that is missing or cannot be right."""
    _each_once("piece", [row.kind for row in rules.pieces], PieceType)
    _each_once("weapon", [row.weapon for row in rules.weapons], Weapon)
    _no_twins("weapon code", [row.code for row in rules.weapons])
    _no_twins("attack row", [row.key for row in rules.attacks])
    _check_names(rules)
    for piece in rules.pieces:
        _check_piece(piece)
    for attack in rules.attacks:
        _check_attack(attack)
    for number in rules.numbers:
        _check_number(number)
    for table in rules.tables:
        _check_table(table)
    _check_weapons(rules)
    _check_sight(rules)
    _check_modifiers(rules)


def _fail(what: str, found: object, expected: object) -> None:
    raise ConfigError(f"rules: {what}: found {found}; expected {expected}")


def _within(what: str, value: object, low: int, high: int) -> None:
    if not isinstance(value, int) or not low <= value <= high:
        _fail(what, value, f"a whole number in {low}..{high}")


def _each_once(what: str, found: Sequence[IntEnum], kind: type[IntEnum]) -> None:
    due = [member.name for member in kind]
    names = [member.name for member in found]
    if names != due:
        _fail(f"{what} rows", ", ".join(names), ", ".join(due))


def _no_twins(what: str, keys: Sequence[object]) -> None:
    for index, key in enumerate(keys):
        if key in keys[:index]:
            _fail(f"{what} {key}", "two rows", "one")


def _check_names(rules: RuleTables) -> None:
    """Numbers and tables fill the record: every field once, and nothing that is no field."""
    names = [row.name for row in rules.numbers] + [row.name for row in rules.tables]
    _no_twins("rule", names)
    due = set(RULES.names or ()) - DERIVED - FROM_ROWS
    for name in sorted(due.symmetric_difference(names)):
        _fail(f"rule {name!r}", "no row" if name in due else "a row", "a row" if name in due else "none")


def _check_piece(row: PieceRow) -> None:
    name = row.kind.name
    most = 1 if row.kind == PieceType.AEROCRAFT else MAX_BLOOD  # section 7: a hit destroys it
    _within(f"blood of {name}", row.blood, 1, most)
    _within(f"value of {name}", row.value, 0, MAX_VALUE)
    _within(f"armour of {name}", row.armour, 0, MAX_ARMOUR)
    _within(f"base_hop of {name}", row.base_hop, 1, MAX_HOP)
    _within(f"pools of {name}", len(row.pools), 1, MAX_POOLS)
    for pool in row.pools:
        _within(f"ammo of {name}", pool.ammo, 0, MAX_BYTE)
    _no_twins(f"weapon of {name}", [weapon for pool in row.pools for weapon in pool.weapons])


def _check_attack(row: AttackRow) -> None:
    name = f"attack of {row.weapon.name} on {row.target.name}"
    _within(f"{name}, rows", len(row.levels), 1, MAX_BLOOD)
    _within(f"{name}, first distance", row.first_cells, 0, MAX_CELLS)
    _within(f"{name}, last distance", row.first_cells + len(row.levels[0]) - 1, 0, MAX_CELLS)
    for levels in row.levels:
        _within(f"{name}, length of a row", len(levels), len(row.levels[0]), len(row.levels[0]))
        for level in levels:
            _within(f"{name}, a level", level, 0, MAX_LEVEL)


def _check_number(number: Number) -> None:
    field = RULES[number.name]
    if field.shape:
        _fail(f"rule {number.name!r}", "a number", "a table")
    _within(number.name, number.value, np.iinfo(field).min, int(np.iinfo(field).max))


def _check_table(table: Table) -> None:
    """A table fills its field of the record to the last row and column."""
    field = RULES[table.name]
    if len(table.first) != len(field.shape):
        _fail(f"table {table.name}", f"{len(table.first)} axes", len(field.shape))
    cells = np.array(table.cells, dtype=object)
    due = tuple(size - max(first, 0) for size, first in zip(field.shape, table.first, strict=True))
    if cells.shape != due:
        _fail(f"shape of table {table.name}", cells.shape, due)
    for entry in cells.flat:
        _within(
            f"an entry of table {table.name}", entry, *TABLE_LIMITS.get(table.name, (-MAX_BYTE, MAX_BYTE))
        )


def _check_weapons(rules: RuleTables) -> None:
    """Every weapon but the mortar, which fires at cells, has an attack level somewhere."""
    armed = {row.weapon for row in rules.attacks}
    for weapon in Weapon:
        if (weapon in armed) == (weapon == Weapon.MORTAR):
            _fail(f"attack rows of {weapon.name}", len(armed & {weapon}), "none for MORTAR, else some")


def _check_sight(rules: RuleTables) -> None:
    ground, air = rules.ground_sight, rules.aerocraft
    for row in (ground, air):
        _within("sight of soldiers", row.soldier_cells, 1, MAX_BYTE)
        _within("sight of vehicles", row.vehicle_cells, 1, MAX_BYTE)
    _within("sight of aerocraft", air.seen_cells, 1, MAX_BYTE)
    base_hop = rules.pieces[PieceType.AEROCRAFT].base_hop
    if base_hop != air.base_hop:
        _fail("base_hop of AEROCRAFT", base_hop, f"{air.base_hop}, as in its profile")
    for name in ("hidden_sight_divisor", "concealed_sight_divisor"):
        _within(name, rules.number(name), 1, MAX_BYTE)


def _check_modifiers(rules: RuleTables) -> None:
    """The odds tables hold every sum of shot modifiers that can occur."""
    values = [row.value for row in rules.numbers if row.name.startswith("mod_")]
    _within("sum of all penalties", sum(min(value, 0) for value in values), LEAST_MODIFIER, 0)
    _within("sum of all bonuses", sum(max(value, 0) for value in values), 0, MOST_MODIFIER)
