"""A rule set is checked, hashed and compiled; another is another instance."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.rules import PieceType, RuleSet, Weapon, default_rules
from hexwar_sb3.rules.rows import Number, Table, numbered

HASHES = {"1.0": "2da2ac091d90bf232ab035d67a866b7e443d8c60e6534b8f580a7cf16e54e23e"}
"""version: hash; a new version adds a row."""


def test_numbers_do_not_change_without_a_new_version(rules: RuleSet) -> None:
    """Results, replays and models name both."""
    assert HASHES.get(rules.version) == rules.hash


def with_one_number_changed(rules: RuleSet) -> Iterator[RuleSet]:
    """Every number by itself."""
    for number in rules.numbers:
        yield rules.with_numbers(**{number.name: number.value + (1 if number.value < 0 else -1)})


def with_one_entry_changed(rules: RuleSet) -> Iterator[RuleSet]:
    """Every table by its last row."""
    for table in rules.tables:
        assert isinstance(table.cells, tuple)
        first, last = table.cells[0], table.cells[-1]
        assert first != last
        yield rules.with_rows(replace(table, cells=(*table.cells[:-1], first)))


def with_one_piece_changed(rules: RuleSet) -> Iterator[RuleSet]:
    """Every property of a piece by itself, and every pool."""
    tank = rules.pieces[PieceType.TANK]
    changes = {"value": 11, "blood": 4, "armour": 3, "base_hop": 10, "moving_fire": False}
    for name, value in changes.items():
        yield rules.with_rows(replace(tank, **{name: value}))  # type: ignore[arg-type]
    for piece in rules.pieces:
        for index, pool in enumerate(piece.pools):
            pools = (*piece.pools[:index], replace(pool, ammo=1), *piece.pools[index + 1 :])
            yield rules.with_rows(replace(piece, pools=pools))


def with_one_attack_changed(rules: RuleSet) -> Iterator[RuleSet]:
    """Every attack row by its last level."""
    for row in rules.attacks:
        *before, last = row.levels[-1]
        levels = (*row.levels[:-1], (*before, last + 1))
        yield rules.with_rows(replace(row, levels=levels))


def with_one_sight_changed(rules: RuleSet) -> Iterator[RuleSet]:
    """The sight of ground pieces, and other aerocraft."""
    yield replace(rules, ground_sight=replace(rules.ground_sight, soldier_cells=9))
    yield replace(rules, ground_sight=replace(rules.ground_sight, vehicle_cells=9))
    yield rules.with_aerocraft("uav")
    yield rules.with_aerocraft("heli")


@pytest.mark.parametrize(
    "neighbours",
    [
        with_one_number_changed,
        with_one_entry_changed,
        with_one_piece_changed,
        with_one_attack_changed,
        with_one_sight_changed,
    ],
)
def test_every_single_change_gives_another_hash_and_another_record(
    neighbours: Callable[[RuleSet], Iterator[RuleSet]], rules: RuleSet
) -> None:
    others = list(neighbours(rules))
    record = rules.compiled().tobytes()

    assert len({other.hash for other in others} | {rules.hash}) == len(others) + 1
    assert all(other.compiled().tobytes() != record for other in others)


def test_the_hash_does_not_depend_on_words(rules: RuleSet) -> None:
    stop = Number("stop_ticks", 75, "seconds", "hearsay")

    assert rules.with_rows(stop).hash == rules.hash
    assert replace(rules, version="2.0").hash == rules.hash


def test_a_rule_set_survives_pickling_with_its_hash(rules: RuleSet) -> None:
    copy = pickle.loads(pickle.dumps(rules))  # noqa: S301

    assert copy == rules
    assert copy.hash == rules.hash


def test_a_second_rule_set_leaves_the_first_alone(rules: RuleSet) -> None:
    record = rules.compiled()
    quick = rules.with_numbers(stop_ticks=50)

    assert quick.compiled()[0].stop_ticks == 50
    assert rules.compiled().tobytes() == record.tobytes()
    assert default_rules() is rules


def test_each_record_is_a_new_one(rules: RuleSet) -> None:
    rules.compiled()[0].stop_ticks = 1

    assert rules.compiled().shape == (1,)
    assert rules.compiled()[0].stop_ticks == 75


def test_an_aerocraft_profile_there_and_back_is_the_same_rule_set(rules: RuleSet) -> None:
    assert rules.with_aerocraft("heli").with_aerocraft("default") == rules


def test_an_unknown_profile_or_rule_is_refused_with_the_nearest_name(rules: RuleSet) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'heli'"):
        rules.with_aerocraft("helo")
    with pytest.raises(UnknownNameError, match="did you mean 'stop_ticks'"):
        rules.number("stop_tick")
    with pytest.raises(ConfigError, match=r"no row .*flood_ticks"):
        rules.with_rows(Number("flood_ticks", 3, "ticks", "hearsay"))


def test_a_missing_row_is_refused_by_name(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match="piece rows: found TANK, CHARIOT, SOLDIER; expected"):
        replace(rules, pieces=rules.pieces[:-1])
    with pytest.raises(ConfigError, match=r"weapon rows: .*MORTAR"):
        replace(rules, weapons=rules.weapons[:-1])
    with pytest.raises(ConfigError, match="'stop_ticks': found no row"):
        replace(rules, numbers=tuple(row for row in rules.numbers if row.name != "stop_ticks"))
    with pytest.raises(ConfigError, match="'burst_guns': found no row"):
        replace(rules, tables=rules.tables[:-1])
    with pytest.raises(ConfigError, match="attack rows of ROCKET"):
        replace(rules, attacks=tuple(row for row in rules.attacks if row.weapon != Weapon.ROCKET))


def test_a_row_given_twice_is_refused(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match="stop_ticks: found two rows"):
        replace(rules, numbers=(*rules.numbers, Number("stop_ticks", 75, "ticks", "hearsay")))
    with pytest.raises(ConfigError, match=r"attack row .*: found two rows"):
        replace(rules, attacks=(*rules.attacks, rules.attacks[0]))


def test_a_number_that_is_no_field_of_the_record_is_refused(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match="'flood_ticks': found a row; expected none"):
        replace(rules, numbers=(*rules.numbers, Number("flood_ticks", 3, "ticks", "hearsay")))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blood": 6}, "blood of TANK: found 6; expected a whole number in 1..5"),
        ({"armour": 5}, "armour of TANK: found 5"),
        ({"base_hop": 0}, "base_hop of TANK: found 0"),
        ({"value": 7.5}, "value of TANK: found 7.5; expected a whole number"),
    ],
)
def test_a_piece_out_of_range_is_refused(changes: dict[str, int], message: str, rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match=message):
        rules.with_rows(replace(rules.pieces[PieceType.TANK], **changes))  # type: ignore[arg-type]


def test_an_aerocraft_has_one_blood(rules: RuleSet) -> None:
    """Rule book, section 7: a hit destroys it."""
    with pytest.raises(ConfigError, match="blood of AEROCRAFT: found 2"):
        rules.with_rows(replace(rules.pieces[PieceType.AEROCRAFT], blood=2))


def test_modifiers_that_the_odds_cannot_hold_are_refused(rules: RuleSet) -> None:
    with pytest.raises(ConfigError, match="sum of all penalties: found -9"):
        rules.with_numbers(mod_target_hidden=-3)


def test_a_table_of_the_wrong_shape_or_entries_is_refused(
    misprint: Callable[..., RuleSet], rules: RuleSet
) -> None:
    column = rules.table("column")
    assert isinstance(column.cells, tuple)
    with pytest.raises(ConfigError, match="shape of table column"):
        rules.with_rows(replace(column, cells=column.cells[:-1]))
    with pytest.raises(ConfigError, match="shape of table column"):
        rules.with_rows(replace(column, cells=(*column.cells[:-1], (3, 5, 9))))
    with pytest.raises(ConfigError, match="an entry of table vehicle_result: found 6"):
        misprint("vehicle_result", 7, 14, entry=6)


def test_a_row_with_a_wrong_number_is_refused() -> None:
    with pytest.raises(ConfigError, match="row 4 where row 3 is due"):
        numbered("2: 1 . S\n4: 1 . .", first=2)


def test_a_table_is_read_with_the_numbers_of_the_rule_book(rules: RuleSet) -> None:
    table = rules.table("vehicle_correction")

    assert table.at(-3, 1) == -1
    assert table.clamped(-9, 1) == -1
    assert table.clamped(14, 4) == 2
    with pytest.raises(ConfigError, match="vehicle_correction has no entry"):
        table.at(-4, 1)
    with pytest.raises(ConfigError, match="vehicle_correction has no entry"):
        table.at(13, 1)
    with pytest.raises(ValueError, match="longer"):
        table.at(12)


def test_a_weapon_is_replaced_by_its_name(rules: RuleSet) -> None:
    row = replace(rules.weapons[Weapon.PORT], code=999)

    assert [weapon.code == 999 for weapon in rules.with_rows(row).weapons].index(True) == Weapon.PORT


def test_the_record_leaves_no_table_empty(rules: RuleSet) -> None:
    record = rules.compiled()

    assert [name for name in record.dtype.names or () if not np.any(record[name])] == ["moving_weapon"]


def test_every_table_has_a_unit(rules: RuleSet) -> None:
    rows: tuple[Number | Table, ...] = (*rules.numbers, *rules.tables)

    assert all(row.unit for row in rows)


def test_the_rules_need_no_compiler_and_no_network_library() -> None:
    """The rules layer imports neither numba nor torch (gymnasium: the package registers its envs there)."""
    code = "import sys, hexwar_sb3.rules as r; r.default_rules().compiled(); print(*sys.modules)"

    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout

    assert not {"numba", "torch"} & set(modules.split())
