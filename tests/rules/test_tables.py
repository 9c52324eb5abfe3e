"""The tables against a second transcription of rows of the rule book."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hexwar_sb3.rules import PieceType, RuleSet, TargetClass, Weapon
from hexwar_sb3.rules.tables import BURST_GUNS

NONE, HIT = -1, -1  # no effect; the sign for a hit in `scatter`

SPOT_ROWS: list[tuple[str, tuple[int, ...], list[int]]] = [
    ("height", (2,), [0, -2, -2, -2, -1, -1, -1, -1, 0, 0, 0, 0, 0]),
    ("height", (8,), [0, -5, -5, -5, -4, -3, -3, -2, -2, -2, -2, -2, -1]),
    ("column", (1,), [0, 1, 3, 4, 5, 6, 7, 8, 9, 11, 12]),
    ("column", (3,), [0, 3, 5, 7, 8, 10, 12, 13, 14, 15, 16]),
    ("vehicle_result", (2,), [0, 1, *5 * [NONE], *8 * [1], 2, 3, 3, 2, 3, 5]),
    ("vehicle_result", (7,), [0, -1, -1, 1, -1, -1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 4, 3, 4, 3]),
    ("vehicle_result", (11,), [0, *10 * [NONE], 2, 2, NONE, NONE, 2, 3, 3, 2, 2, 3]),
    ("soldier_result", (3,), [0, -1, 0, 0, 0, 0, 1, 1, 1, 1, 1]),
    ("soldier_result", (10,), [0, -1, -1, -1, 0, 0, 0, 0, 0, 1, 1]),
    ("vehicle_correction", (-3 + 3,), [0, -1, -2, -3, -3]),
    ("vehicle_correction", (5 + 3,), [1, 0, 0, 0, -1]),
    ("vehicle_correction", (12 + 3,), [3, 3, 3, 2, 2]),
    ("soldier_correction", (), [-1, 0, 0, 0, 0, 0, 0, 0, 1]),
    ("air_kill_level", (), [0, 0, 1, 3, 5, 7, 9, 11, 10, 8, 6, 4, 2]),
    ("scatter", (0, 2), [1, 2, 3, 4]),
    ("scatter", (0, 7), [HIT, 0, 0, 0]),
    ("scatter", (1, 6), [HIT, HIT, 0, 0]),
    ("scatter", (1, 12), [0, 0, 1, 3]),
    ("scatter", (2, 3), [0, 0, 0, 0]),
    ("scatter", (2, 10), [HIT, HIT, HIT, HIT]),
    ("burst_result", (1,), [0, 0, 2, 1, 1, 1, 0, 0, 0, 0, 0, 1, 1]),
    ("burst_result", (0,), [0, 0, 0, 0, 0, -1, -1, -1, -1, 0, -1, 0, 0]),
    ("burst_correction", (), [-2, -2, -1, -1, -1, 0, 0, 0, 1]),
    ("burst_armour", (), [1, 1, 0, -1, -3]),
    ("burst_guns", (), [0, -4, -2, 0, 2, 2]),
]


@pytest.mark.parametrize(("table", "row", "entries"), SPOT_ROWS)
def test_a_row_of_the_record_reads_as_in_the_rule_book(
    table: str, row: tuple[int, ...], entries: list[int], rules: RuleSet
) -> None:
    assert rules.compiled()[0][table][row].tolist() == entries


LEVEL_ROWS = [
    (Weapon.GUN, "vehicle", 3, 0, [10, 10, 10, 10, 10, 9, 9, 9, 9, 8, 8, 8, 7, 7, 6, 5, 4, 3, 2]),
    (Weapon.GUN2, "vehicle", 1, 0, [10, 10, 10, 9, 9, 9, 8, 8, 7, 7, 7, 6, 5, 5, 2, 2]),
    (Weapon.GUN3, "vehicle", 1, 0, [10, 10, 9, 9, 8, 8, 7, 6, 6, 5, 5, 2, 2, 2]),
    (Weapon.CANNON, "vehicle", 2, 0, [5, 5, 4, 4, 3, 3, 3, 2, 2, 2, 2]),
    (Weapon.ROCKET, "vehicle", 3, 0, [6, 6, 6, 4, 2]),
    (Weapon.PORT, "vehicle", 3, 0, [7, 7, 7, *8 * [8]]),
    (Weapon.HEAVY, "vehicle", 3, 2, [5, 5, 6, *16 * [8]]),
    (Weapon.AIRM, "vehicle", 1, 0, [7, 7, 7, *8 * [8]]),
    (Weapon.AIRM2, "vehicle", 1, 0, [7, 7, 7, *18 * [8]]),
    (Weapon.SMALL, "vehicle", 3, 0, [6, 4, 2, 1]),
    (Weapon.GUN, "soldier", 2, 0, 11 * [3]),
    (Weapon.GUN2, "soldier", 4, 0, 11 * [7]),
    (Weapon.GUN3, "soldier", 3, 0, 11 * [4]),
    (Weapon.CANNON, "soldier", 3, 0, [8, 8, 8, 8, 8, 8, 7, 7, 6, 6, 5]),
    (Weapon.LIGHT, "soldier", 1, 0, [2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1]),
    (Weapon.SMALL, "soldier", 1, 0, [2, 1]),
    (Weapon.AIRM, "soldier", 3, 0, [7, *10 * [8]]),
    (Weapon.CANNON, "aerocraft", 3, 0, [3, 3, 2, 2, 1, 1]),
    (Weapon.PORT, "aerocraft", 3, 0, [7, 7, 7, *8 * [8]]),
]


@pytest.mark.parametrize(("weapon", "target", "blood", "first", "levels"), LEVEL_ROWS)
def test_a_weapon_has_its_level_at_every_distance_and_no_shot_beyond(
    weapon: Weapon, target: str, blood: int, first: int, levels: list[int], rules: RuleSet
) -> None:
    """Rule book, section 7: attack level by distance from 0 to 20."""
    row = rules.compiled()[0].level[weapon, TargetClass[target.upper()], blood].tolist()

    assert row == [*first * [0], *levels, *(21 - first - len(levels)) * [0]]


def test_no_weapon_has_a_level_that_the_rule_book_does_not_give(rules: RuleSet) -> None:
    level = rules.compiled()[0].level
    given = {(weapon, TargetClass[target.upper()]) for weapon, target, *_ in LEVEL_ROWS}

    assert {(w, t) for w in Weapon for t in TargetClass if level[w, t].any()} == given


def test_five_blood_shoots_at_soldiers_like_four(rules: RuleSet) -> None:
    """Assumption A24."""
    level = rules.compiled()[0].level[:, TargetClass.SOLDIER]

    assert level[Weapon.CANNON, 4, 0] == 9
    assert (level[:, 5] == level[:, 4]).all()


@pytest.mark.parametrize(
    ("kind", "value", "blood", "armour", "base_hop", "moving_fire"),
    [
        ("TANK", 10, 3, 4, 20, 1),
        ("CHARIOT", 7, 3, 2, 20, 0),
        ("SOLDIER", 4, 3, 0, 144, 0),
        ("AEROCRAFT", 8, 1, 0, 8, 0),
    ],
)
def test_a_piece_is_as_in_the_table_of_pieces(
    kind: str, value: int, blood: int, armour: int, base_hop: int, moving_fire: int, rules: RuleSet
) -> None:
    """Rule book, section 2."""
    record, index = rules.compiled()[0], PieceType[kind]
    names = ("value", "blood", "armour", "base_hop", "moving_fire")

    assert [record[name][index] for name in names] == [value, blood, armour, base_hop, moving_fire]


def test_weapons_that_share_ammunition_read_one_pool(rules: RuleSet) -> None:
    """Rule book, section 2: weapons and ammo."""
    record = rules.compiled()[0]
    ammo = {
        (kind.name, weapon.name): int(record.pool_ammo[kind, record.pool[kind, weapon]])
        for kind in PieceType
        for weapon in Weapon
        if record.pool[kind, weapon] >= 0
    }

    assert ammo == {
        ("TANK", "GUN"): 30, ("TANK", "LIGHT"): 30,
        ("CHARIOT", "CANNON"): 40, ("CHARIOT", "LIGHT"): 40, ("CHARIOT", "HEAVY"): 6, ("CHARIOT", "MORTAR"): 6,
        ("SOLDIER", "SMALL"): 10, ("SOLDIER", "ROCKET"): 10, ("SOLDIER", "PORT"): 4,
        ("AEROCRAFT", "AIRM"): 4,
    }  # fmt: skip
    assert record.pool[PieceType.TANK, Weapon.GUN] == record.pool[PieceType.TANK, Weapon.LIGHT]


def test_the_weapons_carry_the_codes_of_the_platform(rules: RuleSet) -> None:
    codes = [row.code for row in rules.weapons]

    assert codes == [36, 37, 54, 56, 43, 29, 35, 71, 73, 74, 83, 89]


def test_the_pieces_of_a_side_are_worth_134_points(rules: RuleSet) -> None:
    """Rule book, section 2: two of each ground type and one aerocraft."""
    total = [row.value * row.blood for row in rules.pieces]

    assert total == [30, 21, 12, 8]
    assert 2 * sum(total[:3]) + total[3] == 134


def test_timers_and_limits_are_those_of_the_rule_book(rules: RuleSet) -> None:
    """Rule book, sections 1, 3, 4, 6, 9, 10, 12."""
    assert {row.name: row.value for row in rules.numbers} == {
        "max_climb": 5, "slushy_factor": 4, "concealed_factor": 2, "steep_m": 60, "steep_factor": 2,
        "stack_limit": 4, "path_limit": 100, "moving_weapon": 0,
        "stop_ticks": 75, "hide_ticks": 75, "board_ticks": 75, "decompress_ticks": 75, "cool_ticks": 75,
        "decompress_above_ticks": 75, "keep_ticks": 150, "fight_ticks": 75, "game_ticks": 1800,
        "air_height_m": 200, "hidden_sight_divisor": 2, "concealed_sight_divisor": 2,
        "mod_shooter_suppressed": -1, "mod_shooter_moving": -1, "mod_target_concealed": -2,
        "mod_target_hidden": -2, "mod_target_moving": -2, "mod_target_stacked": 2,
        "flight_ticks": 150, "burst_ticks": 450, "mortar_cool_ticks": 300, "mortar_min_cells": 4,
        "mortar_max_cells": 20, "observer_cells": 25, "scatter_band_cells": 20,
        "burst_concealed": -2, "burst_hidden": -2, "burst_soldier_moving": 2, "burst_stacked": 2,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("profile", "base_hop", "sees", "seen"),
    [("default", 8, (5, 5, 2), 5), ("uav", 8, (2, 2, 2), 1), ("heli", 4, (25, 25, 10), 25)],
)
def test_an_aerocraft_sees_and_is_seen_by_its_profile(
    profile: str, base_hop: int, sees: tuple[int, int, int], seen: int, rules: RuleSet
) -> None:
    """Rule book, sections 2 and 6; sight[observer, target] in cells."""
    record = rules.with_aerocraft(profile).compiled()[0]

    assert record.base_hop.tolist() == [20, 20, 144, base_hop]
    assert record.sight.tolist() == [*3 * [[25, 25, 10, seen]], [*sees, seen]]


def test_the_spare_guns_of_indirect_fire_are_kept() -> None:
    """Rule book, section 9: medium and heavy columns."""
    assert BURST_GUNS["medium"].cells == (
        (1, 0, -1, -1, -1, 0, -1, -1, 0, 0, 0),
        (3, 2, 1, 1, 1, 0, 0, 0, 2, 1, 1),
    )
    assert BURST_GUNS["heavy"].cells == (
        (1, 1, 0, -1, 0, 0, -1, -1, 0, 0, 1),
        (3, 2, 2, 1, 1, 0, 1, 0, 2, 1, 2),
    )


def test_every_assumption_that_a_table_names_is_written_down(rules: RuleSet) -> None:
    """docs/assumptions.md numbers them without a gap."""
    page = (Path(__file__).parents[2] / "docs" / "assumptions.md").read_text(encoding="utf-8")
    written = [int(number) for number in re.findall(r"^\| A(\d+) \|", page, re.MULTILINE)]
    named = {int(number) for number in re.findall(r"\bA(\d+)\b", repr(rules))}

    assert written == list(range(1, len(written) + 1))
    assert named
    assert named <= set(written)


def test_every_row_says_where_it_comes_from(rules: RuleSet) -> None:
    sources = re.findall(r"source=(['\"])(.*?)\1", repr(rules))

    assert len(sources) >= len(rules.numbers) + len(rules.tables) + len(rules.attacks)
    assert all(re.match(r"paper, |rule book, section|A\d", source) for _, source in sources)
