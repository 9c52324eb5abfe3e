"""The rule tables as one record, the form that kernels read.

`RuleSet.compiled()` (ruleset.py) fills it from the tables; nothing else writes it.
Index conventions: blood 0..5, level 0..10, distance 0..20, two dice 0..12 (0 and 1 unused),
so that every table is read with the rule book's own number and no offset.
"""

from __future__ import annotations

import numpy as np

NO_EFFECT = -1  # a result table's "."
NO_POOL = -1  # this type of piece does not carry this weapon
LEAST_MODIFIER, MOST_MODIFIER = -8, 2  # sums of shot modifiers that the odds tables hold
LEAST_RESULT, MOST_RESULT = -1, 5  # the last column of the odds: 5 or more, all that a piece can have
SCATTER_HIT = -1  # `scatter`: the round hits; 0: in the cell but off target; n: n cells away

RULES = np.dtype(
    [
        # --- pieces, section 2; [piece type] ---
        ("value", "i2", (4,)),  # points per blood
        ("blood", "i1", (4,)),
        ("armour", "i1", (4,)),  # 0 none .. 4 composite
        ("base_hop", "i2", (4,)),  # ticks per cell on open ground
        ("moving_fire", "i1", (4,)),
        ("power", "i2", (4,)),  # spare column for rough strength (bots)
        ("pool", "i1", (4, 12)),  # [type, weapon] -> ammunition pool 0..3 or NO_POOL
        ("pool_ammo", "i1", (4, 4)),  # [type, pool] rounds at the start
        ("moving_weapon", "i1"),  # the weapon that fires on the move (GUN)
        # --- sight, section 6 ---
        ("sight", "i1", (4, 4)),  # [observer type, target type], cells
        ("air_height_m", "i2"),
        ("hidden_sight_divisor", "i1"),
        ("concealed_sight_divisor", "i1"),
        # --- hop times, section 1 ---
        ("max_climb", "i1"),  # levels (grade steps) that a vehicle climbs
        ("steep_m", "i2"),  # metres above which a soldier needs twice the time
        ("slushy_factor", "i1"),
        ("concealed_factor", "i1"),
        ("steep_factor", "i1"),
        ("stack_limit", "i1"),  # own ground pieces in one cell
        ("path_limit", "i2"),
        # --- timers, sections 3, 4, 9, 10; ticks ---
        ("stop_ticks", "i2"),
        ("hide_ticks", "i2"),
        ("board_ticks", "i2"),
        ("decompress_ticks", "i2"),
        ("cool_ticks", "i2"),
        ("keep_ticks", "i2"),  # natural end of suppression
        ("decompress_above_ticks", "i2"),  # decompress only while keep_left is above this
        ("flight_ticks", "i2"),
        ("burst_ticks", "i2"),  # from launch to the end of the burst
        ("mortar_cool_ticks", "i2"),
        ("fight_ticks", "i2"),  # between two exchanges of close combat
        ("game_ticks", "i2"),
        # --- direct fire, section 7 ---
        ("level", "i1", (12, 3, 6, 21)),  # [weapon, target class, shooter blood, distance]; 0 = no shot
        ("height", "i1", (9, 13)),  # [levels uphill 0..8, distance 0..12]
        ("column", "i1", (6, 11)),  # [shooter blood, level]
        ("vehicle_result", "i1", (13, 21)),  # [two dice, column]
        ("soldier_result", "i1", (13, 11)),  # [two dice, level]; also SMALL against vehicles
        ("vehicle_correction", "i1", (16, 5)),  # [m clamped to -3..12, plus 3; armour]
        ("soldier_correction", "i1", (9,)),  # [m clamped to 0..8]
        ("mod_shooter_suppressed", "i1"),
        ("mod_shooter_moving", "i1"),
        ("mod_target_concealed", "i1"),
        ("mod_target_hidden", "i1"),
        ("mod_target_moving", "i1"),
        ("mod_target_stacked", "i1"),
        ("air_kill_level", "i1", (13,)),  # [two dice] least level that destroys
        # --- indirect fire, section 9 ---
        ("mortar_min_cells", "i1"),
        ("mortar_max_cells", "i1"),
        ("observer_cells", "i1"),  # correction class 1
        ("scatter_band_cells", "i1"),  # launch distances 1-20, 21-40, 41-60, 61+
        ("scatter", "i1", (3, 13, 4)),  # [correction class, two dice, band of the launch distance]
        ("burst_result", "i1", (2, 13)),  # [0 off target, 1 hit; two dice] light gun
        ("burst_correction", "i1", (9,)),  # [m clamped to 0..8]
        ("burst_concealed", "i1"),
        ("burst_hidden", "i1"),
        ("burst_soldier_moving", "i1"),
        ("burst_stacked", "i1"),
        ("burst_armour", "i1", (5,)),
        ("burst_guns", "i1", (6,)),  # [blood at launch]
        # --- chances, from the tables above (odds.py); modifiers from LEAST_MODIFIER, results from -1 ---
        ("odds_vehicle", "f4", (5, 6, 11, 11, 7)),  # [armour, shooter blood, level, modifiers, result]
        ("odds_small", "f4", (5, 11, 11, 7)),  # SMALL against vehicles: [armour, level, modifiers, result]
        ("odds_soldier", "f4", (11, 11, 7)),  # [level, modifiers, result]
        ("odds_air", "f4", (11,)),  # [level]: destroyed
    ],
    align=True,
)
"""Compiled rules, one record; `np.zeros(1, RULES).view(np.recarray)`, kernels take `rules[0]`."""
