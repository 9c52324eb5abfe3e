"""What a rule set may hold: every row complete, every number within what the record and the odds can hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules import PieceType, RuleSet, Weapon
from hexwar_sb3.rules.rows import Number, Pool

LIMITS = {
    "column": (1, 20),
    "vehicle_result": (-1, 5),
    "soldier_result": (-1, 5),
    "vehicle_correction": (-3, 3),
    "soldier_correction": (-3, 3),
    "height": (-10, 0),
    "scatter": (-1, 20),
    "air_kill_level": (-127, 127),
    "burst_guns": (-127, 127),
}


@pytest.mark.parametrize("name", LIMITS)
def test_the_entries_of_a_table_have_their_range(
    name: str, misprint: Callable[..., RuleSet], rules: RuleSet
) -> None:
    low, high = LIMITS[name]
    place = rules.table(name).first
    for entry in (low, high):
        assert misprint(name, *place, entry=entry).table(name).at(*place) == entry
    for entry in (low - 1, high + 1):
        with pytest.raises(
            ConfigError, match=rf"entry of table {name}: found {entry}; .* in {low}\.\.{high}"
        ):
            misprint(name, *place, entry=entry)


def test_a_table_with_too_few_axes_is_refused(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match="table column: found 1 axes; expected 2"):
        rules.with_rows(replace(rules.table("column"), first=(1,)))


@pytest.mark.parametrize(
    ("field", "low", "high"), [("value", 0, 1000), ("blood", 1, 5), ("armour", 0, 4), ("base_hop", 1, 255)]
)
def test_the_numbers_of_a_piece_have_their_range(field: str, low: int, high: int, rules: RuleSet) -> None:
    tank = rules.pieces[PieceType.TANK]
    for value in (low, high):
        changed: dict[str, Any] = {field: value}
        assert getattr(rules.with_rows(replace(tank, **changed)).pieces[0], field) == value
    for value in (low - 1, high + 1):
        changed = {field: value}
        with pytest.raises(ConfigError, match=rf"{field} of TANK: found {value}; .* in {low}\.\.{high}"):
            rules.with_rows(replace(tank, **changed))


def test_a_piece_has_one_to_four_pools_of_up_to_127_rounds_and_each_weapon_once(rules: RuleSet) -> None:
    tank = rules.pieces[PieceType.TANK]
    pool = tank.pools[0]

    def with_pools(*pools: Pool) -> RuleSet:
        return rules.with_rows(replace(tank, pools=pools))

    empty = replace(pool, weapons=())
    assert len(with_pools(pool, empty, empty, empty).pieces[0].pools) == 4
    assert with_pools(replace(pool, ammo=127)).pieces[0].pools[0].ammo == 127
    for pools, message in (
        ((), "pools of TANK: found 0; .* in 1..4"),
        ((pool, empty, empty, empty, empty), "pools of TANK: found 5; .* in 1..4"),
        ((replace(pool, ammo=128),), "ammo of TANK: found 128; .* in 0..127"),
        ((replace(pool, ammo=-1),), "ammo of TANK: found -1; .* in 0..127"),
        ((pool, pool), "weapon of TANK .*: found two rows"),
    ):
        with pytest.raises(ConfigError, match=message):
            with_pools(*pools)


def test_two_weapons_of_one_code_are_refused(rules: RuleSet) -> None:
    first, second, *_ = rules.weapons
    with pytest.raises(ConfigError, match=f"weapon code {first.code}: found two rows"):
        rules.with_rows(replace(second, code=first.code))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"levels": ()}, "rows: found 0; .* in 1..5"),
        ({"levels": ((1,),) * 6}, "rows: found 6; .* in 1..5"),
        ({"first_cells": -1}, "first distance: found -1; .* in 0..20"),
        ({"first_cells": 21, "levels": ((1,),)}, "first distance: found 21; .* in 0..20"),
        ({"first_cells": 0, "levels": ((1,) * 22,)}, "last distance: found 21; .* in 0..20"),
        ({"levels": ((1, 2), (1,))}, "length of a row: found 1; .* in 2..2"),
        ({"levels": ((11,),)}, "a level: found 11; .* in 0..10"),
        ({"levels": ((-1,),)}, "a level: found -1; .* in 0..10"),
    ],
)
def test_an_attack_row_that_the_record_cannot_hold_is_refused(
    change: dict[str, Any], message: str, rules: RuleSet
) -> None:
    with pytest.raises(ConfigError, match=f"attack of GUN on VEHICLE, {message}"):
        rules.with_rows(replace(rules.attacks[0], **change))


def test_an_attack_row_reaches_20_cells(rules: RuleSet) -> None:
    row = replace(rules.attacks[0], first_cells=20, levels=((10,),) * 5)
    assert rules.with_rows(row).attacks[0] == row


def test_a_number_fits_its_field(rules: RuleSet) -> None:
    assert rules.with_numbers(stack_limit=127).number("stack_limit") == 127
    with pytest.raises(ConfigError, match=r"stack_limit: found 128; .* in -128\.\.127"):
        rules.with_numbers(stack_limit=128)


def test_a_number_in_the_place_of_a_table_is_refused(rules: RuleSet) -> None:
    tables = tuple(table for table in rules.tables if table.name != "column")
    numbers = (*rules.numbers, Number("column", 1, "columns", "hearsay"))
    with pytest.raises(ConfigError, match="rule 'column': found a number; expected a table"):
        replace(rules, tables=tables, numbers=numbers)


@pytest.mark.parametrize("cells", [0, 128])
def test_sight_is_1_to_127_cells(cells: int, rules: RuleSet) -> None:
    ground, air = rules.ground_sight, rules.aerocraft
    sights: list[tuple[str, dict[str, Any]]] = [
        ("soldiers", {"ground_sight": replace(ground, soldier_cells=cells)}),
        ("vehicles", {"ground_sight": replace(ground, vehicle_cells=cells)}),
        ("soldiers", {"aerocraft": replace(air, soldier_cells=cells)}),
        ("vehicles", {"aerocraft": replace(air, vehicle_cells=cells)}),
        ("aerocraft", {"aerocraft": replace(air, seen_cells=cells)}),
    ]
    for whom, change in sights:
        with pytest.raises(ConfigError, match=rf"sight of {whom}: found {cells}; .* in 1\.\.127"):
            replace(rules, **change)


def test_sight_is_divided_by_a_whole_number_from_1_on(rules: RuleSet) -> None:
    for name in ("hidden_sight_divisor", "concealed_sight_divisor"):
        assert rules.with_numbers(**{name: 1}).number(name) == 1
        with pytest.raises(ConfigError, match=f"{name}: found 0"):
            rules.with_numbers(**{name: 0})


def test_an_aerocraft_is_as_fast_as_its_profile_says(rules: RuleSet) -> None:
    row = replace(rules.pieces[PieceType.AEROCRAFT], base_hop=9)
    with pytest.raises(ConfigError, match="base_hop of AEROCRAFT: found 9; expected 8, as in its profile"):
        rules.with_rows(row)


def test_bonuses_that_the_odds_cannot_hold_are_refused(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match=r"sum of all bonuses: found 3; .* in 0\.\.2"):
        rules.with_numbers(mod_target_stacked=3)


def test_every_weapon_but_the_mortar_has_attack_rows(rules: RuleSet) -> None:
    """It fires at cells (section 9)."""
    without = tuple(row for row in rules.attacks if row.weapon != Weapon.ROCKET)
    with pytest.raises(
        ConfigError, match="attack rows of ROCKET: found 0; expected none for MORTAR, else some"
    ):
        replace(rules, attacks=without)
    with pytest.raises(ConfigError, match="attack rows of MORTAR: found 1"):
        replace(rules, attacks=(*rules.attacks, replace(rules.attacks[0], weapon=Weapon.MORTAR)))
