"""The rule tables as one record, the form that kernels read.

`RuleSet.compiled()` (ruleset.py) fills it from the tables; nothing else writes it.
Index conventions: blood 0..5, level 0..10, distance 0..20, two dice 0..12 (0 and 1 unused),
so that every table is read with the rule book's own number and no offset.
"""

from __future__ import annotations

from hexwar_sb3.records import F4, I1, I2, Block, Table, Vector, dtype_of, of_shape

NO_EFFECT = -1  # a result table's "."
NO_POOL = -1  # this type of piece does not carry this weapon
LEAST_MODIFIER, MOST_MODIFIER = -8, 2  # sums of shot modifiers that the odds tables hold
LEAST_RESULT, MOST_RESULT = -1, 5  # the last column of the odds: 5 or more, all that a piece can have
SCATTER_HIT = -1  # `scatter`: the round hits; 0: in the cell but off target; n: n cells away


class RulesRecord:
    """The rules of a game."""

    # --- pieces, section 2; [piece type] ---
    value: Vector[int, I2[int]] = of_shape(4)  # points per blood
    blood: Vector[int, I1[int]] = of_shape(4)
    armour: Vector[int, I1[int]] = of_shape(4)  # 0 none .. 4 composite
    base_hop: Vector[int, I2[int]] = of_shape(4)  # ticks per cell on open ground
    moving_fire: Vector[int, I1[int]] = of_shape(4)
    pool: Table[int, int, I1[int]] = of_shape(4, 12)  # [type, weapon] -> ammunition pool 0..3 or NO_POOL
    pool_ammo: Table[int, int, I1[int]] = of_shape(4, 4)  # [type, pool] rounds at the start
    moving_weapon: I1[int]  # the weapon that fires on the move (GUN)
    # --- sight, section 6 ---
    sight: Table[int, int, I1[int]] = of_shape(4, 4)  # [observer type, target type], cells
    air_height_m: I2[int]
    hidden_sight_divisor: I1[int]
    concealed_sight_divisor: I1[int]
    # --- hop times, section 1 ---
    max_climb: I1[int]  # levels (grade steps) that a vehicle climbs
    steep_m: I2[int]  # metres above which a soldier needs twice the time
    slushy_factor: I1[int]
    concealed_factor: I1[int]
    steep_factor: I1[int]
    stack_limit: I1[int]  # own ground pieces in one cell
    path_limit: I2[int]
    # --- timers, sections 3, 4, 9, 10; ticks ---
    stop_ticks: I2[int]
    hide_ticks: I2[int]
    board_ticks: I2[int]
    decompress_ticks: I2[int]
    cool_ticks: I2[int]
    keep_ticks: I2[int]  # natural end of suppression
    decompress_above_ticks: I2[int]  # decompress only while keep_left is above this
    flight_ticks: I2[int]
    burst_ticks: I2[int]  # from launch to the end of the burst
    mortar_cool_ticks: I2[int]
    fight_ticks: I2[int]  # between two exchanges of close combat
    game_ticks: I2[int]
    # --- direct fire, section 7 ---
    # [weapon, target class, shooter blood, distance]; 0 = no shot
    level: Block[I1[int]] = of_shape(12, 3, 6, 21)
    height: Table[int, int, I1[int]] = of_shape(9, 13)  # [levels uphill 0..8, distance 0..12]
    column: Table[int, int, I1[int]] = of_shape(6, 11)  # [shooter blood, level]
    vehicle_result: Table[int, int, I1[int]] = of_shape(13, 21)  # [two dice, column]
    # [two dice, level]; also SMALL against vehicles
    soldier_result: Table[int, int, I1[int]] = of_shape(13, 11)
    vehicle_correction: Table[int, int, I1[int]] = of_shape(16, 5)  # [m clamped to -3..12, plus 3; armour]
    soldier_correction: Vector[int, I1[int]] = of_shape(9)  # [m clamped to 0..8]
    mod_shooter_suppressed: I1[int]
    mod_shooter_moving: I1[int]
    mod_target_concealed: I1[int]
    mod_target_hidden: I1[int]
    mod_target_moving: I1[int]
    mod_target_stacked: I1[int]
    air_kill_level: Vector[int, I1[int]] = of_shape(13)  # [two dice] least level that destroys
    # --- indirect fire, section 9 ---
    mortar_min_cells: I1[int]
    mortar_max_cells: I1[int]
    observer_cells: I1[int]  # correction class 1
    scatter_band_cells: I1[int]  # launch distances 1-20, 21-40, 41-60, 61+
    scatter: Block[I1[int]] = of_shape(3, 13, 4)  # [correction class, two dice, band of the launch distance]
    burst_result: Table[int, int, I1[int]] = of_shape(2, 13)  # [0 off target, 1 hit; two dice] light gun
    burst_correction: Vector[int, I1[int]] = of_shape(9)  # [m clamped to 0..8]
    burst_concealed: I1[int]
    burst_hidden: I1[int]
    burst_soldier_moving: I1[int]
    burst_stacked: I1[int]
    burst_armour: Vector[int, I1[int]] = of_shape(5)
    burst_guns: Vector[int, I1[int]] = of_shape(6)  # [blood at launch]
    # --- chances, from the tables above (odds.py); modifiers from LEAST_MODIFIER, results from -1 ---
    # [armour, shooter blood, level, modifiers, result]
    odds_vehicle: Block[F4[float]] = of_shape(5, 6, 11, 11, 7)
    # SMALL against vehicles: [armour, level, modifiers, result]
    odds_small: Block[F4[float]] = of_shape(5, 11, 11, 7)
    odds_soldier: Block[F4[float]] = of_shape(11, 11, 7)  # [level, modifiers, result]
    odds_air: Vector[int, F4[float]] = of_shape(11)  # [level]: destroyed


RULES = dtype_of(RulesRecord)
"""Compiled rules, one record; `np.zeros(1, RULES).view(np.recarray)`, kernels take `rules[0]`."""
