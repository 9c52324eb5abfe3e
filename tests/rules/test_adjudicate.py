"""One shot by hand: section 7 of the rule book."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules import RuleSet, TargetClass, Weapon, adjudicate


class Record(NamedTuple):
    """One adjudication of the public platform; `uphill` in levels."""

    code: int
    cells: int
    uphill: int
    level: int
    blood: int
    roll1: int
    raw: int
    roll2: int
    mods: int
    armour: int
    corr: int
    result: int


RECORDS = (
    Record(69, 19, 0, 8, 3, 7, 3, 12, -2, 2, 1, 4),
    Record(37, 6, 1, 8, 4, 5, 1, 10, -3, 4, 0, 1),
    Record(36, 6, -1, 9, 2, 10, 2, 9, -4, 4, -1, 1),
    Record(37, 4, 1, 8, 3, 6, 1, 5, -4, 4, -2, -1),
    Record(36, 0, 0, 10, 2, 8, 2, 5, -2, 2, 0, 2),
    Record(37, 0, 0, 10, 4, 9, 4, 10, -3, 4, 0, 4),
    Record(56, 0, 0, 5, 1, 5, 1, 9, -3, 4, 0, 1),
    Record(56, 0, 0, 5, 2, 8, 1, 6, -3, 4, -1, 0),
)
FOREIGN = 69  # a weapon that no piece of ours carries

recorded = pytest.mark.parametrize("shot", RECORDS, ids=str)


@recorded
def test_a_recorded_shot_has_its_recorded_result(shot: Record) -> None:
    """Rule book, section 7: test vectors; modifiers are added to the second roll."""
    result = adjudicate("vehicle", shot.level, shot.blood, shot.armour, shot.roll1, shot.roll2, shot.mods)

    assert result == shot.result


@recorded
def test_a_recorded_shot_has_its_recorded_raw_result_and_correction(shot: Record, rules: RuleSet) -> None:
    column = rules.table("column").at(shot.blood, shot.level)

    assert rules.table("vehicle_result").at(shot.roll1, column) == shot.raw
    assert rules.table("vehicle_correction").clamped(shot.roll2 + shot.mods, shot.armour) == shot.corr


@pytest.mark.parametrize("shot", [shot for shot in RECORDS if shot.code != FOREIGN], ids=str)
def test_a_recorded_shot_has_its_recorded_level(shot: Record, rules: RuleSet) -> None:
    weapon = next(row.weapon for row in rules.weapons if row.code == shot.code)
    record = rules.compiled()[0]

    level = record.level[weapon, TargetClass.VEHICLE, shot.blood, shot.cells]

    assert level + record.height[max(shot.uphill, 0), shot.cells] == shot.level


def test_a_good_correction_makes_a_loss_of_a_shot_without_effect() -> None:
    """Result = raw + correction: m = 12 adds 3 to a raw 1 and to a raw -1."""
    assert adjudicate("vehicle", 8, 3, armour=0, roll1=12, roll2=12, modifiers=0) == 4
    assert adjudicate("vehicle", 1, 3, armour=0, roll1=12, roll2=12, modifiers=0) == 2


def test_a_result_is_never_less_than_no_effect() -> None:
    assert adjudicate("vehicle", 1, 1, armour=4, roll1=12, roll2=2, modifiers=-8) == -1


def test_against_soldiers_the_result_is_read_by_level_and_one_die() -> None:
    """Roll 2 at level 6 is 2 losses; one die of 1 and a penalty of 1 make m = 0: -1."""
    assert adjudicate("soldier", 6, 3, 0, roll1=2, roll2=3, modifiers=0) == 2
    assert adjudicate("soldier", 6, 3, 0, roll1=2, roll2=1, modifiers=-1) == 1
    assert adjudicate("soldier", 6, 3, 0, roll1=2, roll2=6, modifiers=2) == 3
    assert adjudicate("soldier", 6, 3, 0, roll1=6, roll2=3, modifiers=0) == 0


def test_against_soldiers_the_blood_of_the_shooter_counts_only_in_the_level() -> None:
    results = {adjudicate("soldier", 6, blood, 0, 2, 3, 0) for blood in range(1, 6)}

    assert results == {2}


def test_small_arms_read_the_soldier_table_and_the_vehicle_correction() -> None:
    """SMALL at level 5: roll 2 is 1 loss; m = 12 on armour 0 adds 3."""
    assert adjudicate("vehicle", 5, 3, 0, roll1=2, roll2=12, modifiers=0, small_arms=True) == 4
    assert adjudicate("vehicle", 5, 3, 4, roll1=2, roll2=2, modifiers=0, small_arms=True) == -1


@pytest.mark.parametrize(("level", "hits"), [(8, 20), (3, 4), (2, 2)])
def test_an_aerocraft_is_destroyed_by_one_roll_of_two_dice(level: int, hits: int) -> None:
    rolls = [first + second for first in range(1, 7) for second in range(1, 7)]
    results = [adjudicate("aerocraft", level, 3, 0, roll, 0, 0) for roll in rolls]

    assert (results.count(1), results.count(-1)) == (hits, 36 - hits)


def test_a_target_class_may_be_named_in_either_case() -> None:
    results = {adjudicate(name, 8, 3, 2, 7, 12, -2) for name in ("vehicle", "VEHICLE", TargetClass.VEHICLE)}

    assert results == {4}
    assert adjudicate(TargetClass.SOLDIER, 6, 3, 0, 2, 3, 0) == adjudicate("soldier", 6, 3, 0, 2, 3, 0)


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        *[("level", 0), ("level", 11), ("shooter_blood", 0), ("shooter_blood", 6)],
        *[("armour", -1), ("armour", 5), ("roll1", 1), ("roll1", 13), ("roll2", 1), ("roll2", 13)],
    ],
)
def test_an_argument_out_of_range_is_refused_by_name(argument: str, value: int) -> None:
    shot = {"level": 8, "shooter_blood": 3, "armour": 2, "roll1": 7, "roll2": 7, "modifiers": 0}

    with pytest.raises(ConfigError, match=f"{argument} must be in .*, got {value}"):
        adjudicate("vehicle", **(shot | {argument: value}))  # type: ignore[arg-type]


def test_one_die_does_not_show_seven() -> None:
    with pytest.raises(ConfigError, match=r"roll2 must be in 1\.\.6, got 7"):
        adjudicate("soldier", 8, 3, 0, 7, 7, 0)


def test_an_unknown_target_class_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="'ship'; known: vehicle, soldier, aerocraft"):
        adjudicate("ship", 8, 3, 0, 7, 7, 0)


def test_a_changed_row_changes_the_adjudication(misprint: Callable[..., RuleSet]) -> None:
    """The first recorded shot reads column 14 of roll 7 and the row of m = 10."""
    shot = ("vehicle", 8, 3, 2, 7, 12, -2)

    assert adjudicate(*shot, rules=misprint("column", 3, 8, entry=1)) == 0
    assert adjudicate(*shot, rules=misprint("vehicle_result", 7, 14, entry=1)) == 2
    assert adjudicate(*shot, rules=misprint("vehicle_correction", 10, 2, entry=-1)) == 2
    assert adjudicate(*shot) == 4


def test_the_spare_weapons_carry_no_ammunition(rules: RuleSet) -> None:
    carried = {weapon for piece in rules.pieces for pool in piece.pools for weapon in pool.weapons}

    assert set(Weapon) - carried == {Weapon.GUN2, Weapon.GUN3, Weapon.AIRM2}
