"""Every number of the rules, and only here: one table a section of the rule book.

Each row says where its numbers come from: a section of the paper, a public fact ("rule book,
section n") or an assumption of ours ("A7" in docs/assumptions.md).
A changed number is a new version; docs/assumptions.md says why.
"""

from __future__ import annotations

from hexwar_sb3.rules.enums import PieceType, TargetClass, Weapon
from hexwar_sb3.rules.rows import (
    AerocraftProfile,
    AttackRow,
    GroundSight,
    Number,
    PieceRow,
    Pool,
    Table,
    WeaponRow,
    lines,
    numbered,
    numbers,
)

VERSION = "1.0"

# --- section 1: hop times -------------------------------------------------------------------------

HOPS = (
    Number("max_climb", 5, "levels", "rule book, section 1"),
    Number("slushy_factor", 4, "times", "rule book, section 1"),
    Number("concealed_factor", 2, "times", "rule book, section 1"),
    Number("steep_m", 60, "metres", "rule book, section 1"),
    Number("steep_factor", 2, "times", "rule book, section 1"),
    Number("stack_limit", 4, "pieces", "rule book, section 5"),
    Number("path_limit", 100, "cells", "rule book, section 4"),
)

# --- section 2: pieces ----------------------------------------------------------------------------

AEROCRAFT = {
    "default": AerocraftProfile(
        name="default", base_hop=8, soldier_cells=2, vehicle_cells=5, seen_cells=5,
        source="rule book, section 1; sight: A11",
    ),
    "uav": AerocraftProfile(
        name="uav", base_hop=8, soldier_cells=2, vehicle_cells=2, seen_cells=1,
        source="rule book, sections 1 and 2; A26",
    ),
    "heli": AerocraftProfile(
        name="heli", base_hop=4, soldier_cells=10, vehicle_cells=25, seen_cells=25,
        source="rule book, section 2; A26",
    ),
}  # fmt: skip

PIECES = (
    PieceRow(
        kind=PieceType.TANK, value=10, blood=3, armour=4, base_hop=20, moving_fire=True,
        pools=(
            Pool(weapons=(Weapon.GUN, Weapon.LIGHT), ammo=30, source="rule book, section 2"),
        ),
        source="rule book, section 2",
    ),
    PieceRow(
        kind=PieceType.CHARIOT, value=7, blood=3, armour=2, base_hop=20, moving_fire=False,
        pools=(
            Pool(weapons=(Weapon.CANNON, Weapon.LIGHT), ammo=40, source="rule book, section 2"),
            Pool(weapons=(Weapon.HEAVY,), ammo=6, source="rule book, section 2"),
            Pool(weapons=(Weapon.MORTAR,), ammo=6, source="A7"),
        ),
        source="rule book, section 2",
    ),
    PieceRow(
        kind=PieceType.SOLDIER, value=4, blood=3, armour=0, base_hop=144, moving_fire=False,
        pools=(
            Pool(weapons=(Weapon.SMALL, Weapon.ROCKET), ammo=10, source="rule book, section 2"),
            Pool(weapons=(Weapon.PORT,), ammo=4, source="rule book, section 2"),
        ),
        source="rule book, section 2",
    ),
    PieceRow(
        kind=PieceType.AEROCRAFT, value=8, blood=1, armour=0, moving_fire=False,
        base_hop=AEROCRAFT["default"].base_hop,
        pools=(Pool(weapons=(Weapon.AIRM,), ammo=4, source="A10"),),
        source="A8, A9",
    ),
)  # fmt: skip

WEAPONS = (
    WeaponRow(weapon=Weapon.GUN, code=36, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.GUN2, code=37, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.GUN3, code=54, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.CANNON, code=56, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.LIGHT, code=43, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.SMALL, code=29, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.ROCKET, code=35, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.PORT, code=71, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.HEAVY, code=73, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.AIRM, code=74, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.AIRM2, code=83, source="rule book, section 7"),
    WeaponRow(weapon=Weapon.MORTAR, code=89, source="rule book, section 2"),
)
MOVING_WEAPON = Number("moving_weapon", Weapon.GUN, "weapon", "rule book, section 2")

# --- sections 3, 4, 10, 12: timers ----------------------------------------------------------------

TIMERS = (
    Number("stop_ticks", 75, "ticks", "rule book, section 4"),
    Number("hide_ticks", 75, "ticks", "rule book, section 4"),
    Number("board_ticks", 75, "ticks", "rule book, section 4"),
    Number("decompress_ticks", 75, "ticks", "A14"),
    Number("decompress_above_ticks", 75, "ticks", "A14"),
    Number("cool_ticks", 75, "ticks", "rule book, section 4"),
    Number("keep_ticks", 150, "ticks", "rule book, section 3"),
    Number("fight_ticks", 75, "ticks", "A23"),
    Number("game_ticks", 1800, "ticks", "rule book, section 12"),
)

# --- section 6: sight -----------------------------------------------------------------------------

GROUND_SIGHT = GroundSight(soldier_cells=10, vehicle_cells=25, source="rule book, section 6")
SIGHT = (
    Number("air_height_m", 200, "metres", "rule book, section 6"),
    Number("hidden_sight_divisor", 2, "times", "rule book, section 6"),
    Number("concealed_sight_divisor", 2, "times", "rule book, section 6"),
)

# --- section 7: direct fire -----------------------------------------------------------------------

GUN_SOLDIER = lines("""
    2 2 2 2 2 2 2 2 2 2 2
    3 3 3 3 3 3 3 3 3 3 3
    5 5 5 5 5 5 5 5 5 5 5
    7 7 7 7 7 7 7 7 7 7 7
""")
SMALL_ARMS = lines("""
    2 1 0 0
    4 2 1 0
    6 4 2 1
    8 5 3 1
""")


def _attack(
    weapon: Weapon, target: TargetClass, text: str | tuple[tuple[int, ...], ...], first: int = 0
) -> AttackRow:
    """Attack levels by distance from `first` cells; 0: no shot."""
    levels = lines(text) if isinstance(text, str) else text
    return AttackRow(
        weapon=weapon,
        target=target,
        first_cells=first,
        levels=levels,
        source="rule book, section 7",
    )


ATTACKS = (
    _attack(Weapon.GUN, TargetClass.VEHICLE, "10 10 10 10 10 9 9 9 9 8 8 8 7 7 6 5 4 3 2"),
    _attack(Weapon.GUN2, TargetClass.VEHICLE, "10 10 10 9 9 9 8 8 7 7 7 6 5 5 2 2"),
    _attack(Weapon.GUN3, TargetClass.VEHICLE, "10 10 9 9 8 8 7 6 6 5 5 2 2 2"),
    _attack(Weapon.CANNON, TargetClass.VEHICLE, "5 5 4 4 3 3 3 2 2 2 2"),
    _attack(Weapon.ROCKET, TargetClass.VEHICLE, "6 6 6 4 2"),
    _attack(Weapon.PORT, TargetClass.VEHICLE, "7 7 7 8 8 8 8 8 8 8 8"),
    _attack(Weapon.HEAVY, TargetClass.VEHICLE, "5 5 6 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8", first=2),
    _attack(Weapon.AIRM, TargetClass.VEHICLE, "7 7 7 8 8 8 8 8 8 8 8"),
    _attack(Weapon.AIRM2, TargetClass.VEHICLE, "7 7 7 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8"),
    _attack(Weapon.SMALL, TargetClass.VEHICLE, SMALL_ARMS),
    _attack(Weapon.GUN, TargetClass.SOLDIER, GUN_SOLDIER),
    _attack(Weapon.GUN2, TargetClass.SOLDIER, GUN_SOLDIER),
    _attack(Weapon.GUN3, TargetClass.SOLDIER, """
        1 1 1 1 1 1 1 1 1 1 1
        2 2 2 2 2 2 2 2 2 2 2
        4 4 4 4 4 4 4 4 4 4 4
        5 5 5 5 5 5 5 5 5 5 5
    """),
    _attack(Weapon.CANNON, TargetClass.SOLDIER, """
        4 4 4 4 4 4 3 3 3 2 2
        6 6 6 6 6 6 5 5 4 4 3
        8 8 8 8 8 8 7 7 6 6 5
        9 9 9 9 9 9 8 8 7 7 6
    """),
    _attack(Weapon.LIGHT, TargetClass.SOLDIER, """
        2 2 2 2 2 1 1 1 1 1 1
        3 3 3 3 3 2 2 2 2 2 2
        4 4 4 4 4 3 3 3 3 3 3
        5 5 5 5 5 4 4 4 4 4 4
    """),
    _attack(Weapon.SMALL, TargetClass.SOLDIER, SMALL_ARMS),
    _attack(Weapon.AIRM, TargetClass.SOLDIER, """
        4 5 5 5 5 5 5 5 5 5 5
        5 6 6 6 6 6 6 6 6 6 6
        7 8 8 8 8 8 8 8 8 8 8
        8 9 9 9 9 9 9 9 9 9 9
    """),
    _attack(Weapon.CANNON, TargetClass.AEROCRAFT, "3 3 2 2 1 1"),
    _attack(Weapon.PORT, TargetClass.AEROCRAFT, "7 7 7 8 8 8 8 8 8 8 8"),
)  # fmt: skip

MODIFIERS = (
    Number("mod_shooter_suppressed", -1, "modifier", "rule book, section 7"),
    Number("mod_shooter_moving", -1, "modifier", "rule book, section 7"),
    Number("mod_target_concealed", -2, "modifier", "A18"),
    Number("mod_target_hidden", -2, "modifier", "rule book, section 7"),
    Number("mod_target_moving", -2, "modifier", "rule book, section 7"),
    Number("mod_target_stacked", 2, "modifier", "rule book, section 7"),
)

DIRECT_FIRE = (
    Table(name="height", first=(1, 1), unit="levels; [levels uphill, distance in cells]",
          source="rule book, section 7; A17", cells=numbered("""
        1: -2 -2 -1 -1 -1  0  0  0  0  0  0  0
        2: -2 -2 -2 -1 -1 -1 -1  0  0  0  0  0
        3: -3 -2 -2 -2 -1 -1 -1 -1 -1  0  0  0
        4: -3 -3 -3 -2 -2 -1 -1 -1 -1 -1 -1  0
        5: -4 -3 -3 -3 -2 -2 -2 -1 -1 -1 -1 -1
        6: -4 -4 -4 -3 -3 -2 -2 -2 -1 -1 -1 -1
        7: -5 -4 -4 -4 -3 -2 -2 -2 -2 -1 -1 -1
        8: -5 -5 -5 -4 -3 -3 -2 -2 -2 -2 -2 -1
    """, first=1)),
    Table(name="column", first=(1, 1), unit="column; [shooter blood, level]",
          source="rule book, section 7", cells=numbered("""
        1: 1 3 4  5  6  7  8  9 11 12
        2: 2 4 6  7  8  9 10 12 13 14
        3: 3 5 7  8 10 12 13 14 15 16
        4: 3 5 7  9 11 13 14 15 17 18
        5: 3 5 9 11 14 15 16 18 19 20
    """, first=1)),
    Table(name="vehicle_result", first=(2, 1), unit="blood; [two dice, column]",
          source="rule book, section 7", cells=numbered("""
         2: 1 . . . . . 1 1 1 1 1 1 1 1 2 3 3 2 3 5
         3: . . . 1 . . 1 . . 1 1 1 1 1 2 3 3 2 1 1
         4: . 1 . 1 1 . . 1 1 1 1 1 1 1 1 1 1 1 1 1
         5: . . . 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1
         6: . . . . 1 1 1 1 1 1 1 1 1 1 1 1 1 1 3 5
         7: . . 1 . . 1 1 1 2 2 2 2 2 3 3 3 4 3 4 3
         8: . . . . . . . 1 1 1 . . 2 2 2 2 2 4 4 4
         9: . . . . . . . . . 1 2 2 2 2 2 2 2 4 3 4
        10: . . . . . . . . . . . 1 2 2 2 2 2 4 4 4
        11: . . . . . . . . . . 2 2 . . 2 3 3 2 2 3
        12: . . . . . . . . . . . . . 1 2 3 3 3 2 4
    """, first=2)),
    Table(name="soldier_result", first=(2, 1), unit="blood; [two dice, level]",
          source="rule book, section 7", cells=numbered("""
         2: S S S S 1 2 2 2 2 2
         3: . S S S S 1 1 1 1 1
         4: . . S S S S S 1 1 1
         5: . . . . S S S S 1 1
         6: . . . . . S S S S S
         7: . . . . . . S S S S
         8: . . . . . . S S S S
         9: . . . . . S S S S 1
        10: . . . S S S S S 1 1
        11: . S S S S S S 1 1 2
        12: S S S S S 1 2 2 2 2
    """, first=2)),
    Table(name="vehicle_correction", first=(-3, 0), unit="blood; [two dice + modifiers, armour]",
          source="rule book, section 7", cells=numbered("""
        -3: 0 -1 -2 -3 -3
        -2: 0  0 -1 -2 -3
        -1: 0  0 -1 -2 -3
         0: 0  0  0 -1 -3
         1: 0  0  0 -1 -2
         2: 0  0  0  0 -2
         3: 1  0  0  0 -1
         4: 1  0  0  0 -1
         5: 1  0  0  0 -1
         6: 1  1  0  0  0
         7: 1  1  0  0  0
         8: 1  1  0  0  0
         9: 1  1  1  0  0
        10: 2  2  1  1  0
        11: 2  2  2  2  1
        12: 3  3  3  2  2
    """, first=-3)),
    Table(name="soldier_correction", first=(0,), unit="blood; [one die + modifiers]",
          source="rule book, section 7", cells=numbers("-1 0 0 0 0 0 0 0 1")),
    Table(name="air_kill_level", first=(2,), unit="least level that destroys; [two dice]",
          source="rule book, section 7", cells=numbers("1 3 5 7 9 11 10 8 6 4 2")),
)  # fmt: skip

# --- section 9: indirect fire ---------------------------------------------------------------------

MORTAR = (
    Number("flight_ticks", 150, "ticks", "rule book, section 9"),
    Number("burst_ticks", 450, "ticks from launch", "rule book, section 9"),
    Number("mortar_cool_ticks", 300, "ticks", "rule book, section 3"),
    Number("mortar_min_cells", 4, "cells", "A13"),
    Number("mortar_max_cells", 20, "cells", "A13"),
    Number("observer_cells", 25, "cells", "rule book, section 9"),
    Number("scatter_band_cells", 20, "cells", "rule book, section 9"),
    Number("burst_concealed", -2, "modifier", "rule book, section 9"),
    Number("burst_hidden", -2, "modifier", "rule book, section 9"),
    Number("burst_soldier_moving", 2, "modifier", "rule book, section 9"),
    Number("burst_stacked", 2, "modifier", "rule book, section 9"),
)

_SCATTER = (
    """
     2: 1 2 3 4
     3: 1 1 2 3
     4: H 1 1 2
     5: s s 1 1
     6: s s s 1
     7: H s s s
     8: s s s 1
     9: s s 1 1
    10: H 1 1 2
    11: 1 1 2 3
    12: 1 2 3 4
    """,
    """
     2: s s 1 3
     3: s s 1 2
     4: s s s 1
     5: H s s 1
     6: H H s s
     7: H H H s
     8: H H s s
     9: H s s 1
    10: s s s 1
    11: s s s 2
    12: s s 1 3
    """,
    """
     2: s s s s
     3: s s s s
     4: H H H H
     5: H H H H
     6: H H H H
     7: H H H H
     8: H H H H
     9: H H H H
    10: H H H H
    11: s s s s
    12: s s s s
    """,
)
SCATTER = Table(
    name="scatter",
    first=(0, 2, 0),
    unit="cells, 0 off target, H hit; [correction class, two dice, band of the launch distance]",
    source="rule book, section 9",
    cells=tuple(numbered(text, first=2) for text in _SCATTER),
)


def _burst(off: str, hit: str) -> Table:
    """Results of a round, by two dice from 2: off target, then on target."""
    return Table(
        name="burst_result",
        first=(0, 2),
        unit="blood; [0 off target, 1 hit; two dice]",
        source="rule book, section 9",
        cells=(numbers(off), numbers(hit)),
    )


BURST_GUNS = {
    "light": _burst(off="S S S . . . . S . S S", hit="2 1 1 1 S S S S S 1 1"),
    "medium": _burst(off="1 S . . . S . . S S S", hit="3 2 1 1 1 S S S 2 1 1"),
    "heavy": _burst(off="1 1 S . S S . . S S 1", hit="3 2 2 1 1 S 1 S 2 1 2"),
}
"""The chariot's mortar reads the light column; the others are kept for other rule sets."""

BURSTS = (
    BURST_GUNS["light"],
    Table(name="burst_correction", first=(0,), unit="blood; [one die + modifiers]",
          source="rule book, section 9", cells=numbers("-2 -2 -1 -1 -1 0 0 0 1")),
    Table(name="burst_armour", first=(0,), unit="modifier; [armour]",
          source="rule book, section 9; none: A22", cells=numbers("1 1 0 -1 -3")),
    Table(name="burst_guns", first=(1,), unit="modifier; [blood at launch]",
          source="rule book, section 9; 5: A24", cells=numbers("-4 -2 0 2 2")),
)  # fmt: skip

# --------------------------------------------------------------------------------------------------

NUMBERS = (*HOPS, MOVING_WEAPON, *TIMERS, *SIGHT, *MODIFIERS, *MORTAR)
TABLES = (*DIRECT_FIRE, SCATTER, *BURSTS)
