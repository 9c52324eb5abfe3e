"""What a shot is worth: expected points from the exact odds tables (bots.md, section 1).

An enemy is read through the camp's memory only, so a value never tells more than the camp knows.
`allotted[j]` holds the losses that other shooters of this step are already expected to cause.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.fire import clamp
from hexwar_sb3.engine.legality import may_fire_now
from hexwar_sb3.engine.pieces import in_fight, in_motion, is_settled, on_map, weapon_ammo
from hexwar_sb3.engine.records import NEVER, NO_PIECE, GameRecord, Memory, Orders, PieceRecord, Pieces
from hexwar_sb3.engine.sight import sees_itself
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import LEAST_MODIFIER, LEAST_RESULT, RulesRecord
from hexwar_sb3.rules.enums import Action, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range, point_range
from hexwar_sb3.tasks.known import end_piece, first_piece, known_in, level_from

NO_WEAPON = -1

# How bots.md weighs a shot (our choice, no rule): shares of the value of one unit of blood.
SOLDIER_SUPPRESSED = 0.5
VEHICLE_SUPPRESSED = 0.25
KILL_BONUS = 0.5
OBJECTIVE_FACTOR = 1.5
MEDIAN = 0.5

_NOTHING = 0 - LEAST_RESULT  # column of "suppressed" in the odds tables; n losses stand n further


@kernel
def chance(
    weapon: int, blood: int, level: int, mods: int, target_kind: int, result: int, rules: RulesRecord
) -> float:
    """Chance of one result of a shot: 0 suppressed, n losses (section 7).

    Args:
        blood: the shooter's; level: attack level 1..10; mods: sum of the correction's modifiers.
        result: 0..6; an aerocraft knows only 1 (destroyed).
    """
    if target_kind == PieceType.AEROCRAFT:
        return float(rules.odds_air[level]) if result == 1 else 0.0
    m = clamp(mods - LEAST_MODIFIER, 0, rules.odds_soldier.shape[1] - 1)
    n = result + _NOTHING
    if target_kind == PieceType.SOLDIER:
        return float(rules.odds_soldier[level, m, n])
    armour = rules.armour[target_kind]
    if weapon == Weapon.SMALL:
        return float(rules.odds_small[armour, level, m, n])
    return float(rules.odds_vehicle[armour, min(blood, rules.odds_vehicle.shape[1] - 1), level, m, n])


@kernel
def expected_value(
    weapon: int, blood: int, level: int, mods: int, target_kind: int, target_blood: int, bonus: bool,
    rules: RulesRecord,
) -> float:  # fmt: skip
    """Expected points of a shot; with `bonus` also half a unit's value for the chance to destroy."""
    light = SOLDIER_SUPPRESSED if target_kind == PieceType.SOLDIER else VEHICLE_SUPPRESSED
    units = light * chance(weapon, blood, level, mods, target_kind, 0, rules)
    kill = 0.0
    for n in range(1, rules.odds_soldier.shape[2] - _NOTHING):
        p = chance(weapon, blood, level, mods, target_kind, n, rules)
        units += min(n, target_blood) * p
        if n >= target_blood:
            kill += p
    if bonus:
        units += KILL_BONUS * kill
    return float(rules.value[target_kind]) * units


@kernel
def median_loss(
    weapon: int, blood: int, level: int, mods: int, target_kind: int, target_blood: int, rules: RulesRecord
) -> int:
    """Losses that a shot causes with a chance of at least one half."""
    loss = 0
    at_least = 0.0
    for n in range(rules.odds_soldier.shape[2] - _NOTHING - 1, 0, -1):
        at_least += chance(weapon, blood, level, mods, target_kind, n, rules)
        if at_least >= MEDIAN:
            loss = n
            break
    return min(loss, target_blood)


@kernel
def target_mods(
    camp: CampIndex,
    j: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Modifiers of a shot that come from the target, as the camp knows it."""
    known = memory[camp, j]
    mods = 0
    if cells[known.cell].concealed:
        mods += int(rules.mod_target_concealed)
    if known.hidden:
        mods += int(rules.mod_target_hidden)
    if known.moving:
        mods += int(rules.mod_target_moving)
    if known_in(camp, known.cell, game, pieces, memory) >= 2:
        mods += int(rules.mod_target_stacked)
    return mods


@kernel
def shooter_mods(piece: PieceRecord, settled: bool, rules: RulesRecord) -> int:
    """Modifiers of a shot that come from the shooter; `settled`: as if it stood still."""
    mods = 0
    if piece.suppressed:
        mods += int(rules.mod_shooter_suppressed)
    if in_motion(piece) and not settled:
        mods += int(rules.mod_shooter_moving)
    return mods


@kernel
def is_objective(camp: CampIndex, cell: CellIndex, game: GameRecord, cells: Cells) -> bool:
    """Within one cell of a control point that is not the camp's own."""
    for k in point_range(game.n_points):
        if game.point_owner[k] != camp and cells_apart(cells, cell, game.point_cell[k]) <= 1:
            return True
    return False


@kernel
def shot_value(
    i: PieceIndex, j: PieceIndex, weapon: int, settled: bool, allotted: Rows,
    game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord, cells: Cells,
) -> float:  # fmt: skip
    """Expected points of a shot of piece i at known enemy j, with all bonuses; 0: no level.

    Legality is not asked: `best_shot` does. `settled` leaves out the shooter's own motion.
    """
    piece = pieces[i]
    kind = pieces[j].kind
    known = memory[piece.camp, j]
    blood = int(known.blood) - int(allotted[j])
    level = level_from(weapon, piece.kind, piece.blood, piece.cell, kind, known.cell, rules, cells)
    if level == 0 or blood <= 0:
        return 0.0
    mods = shooter_mods(piece, settled, rules)
    mods += target_mods(piece.camp, j, game, pieces, memory, rules, cells)
    value = expected_value(weapon, piece.blood, level, mods, kind, blood, True, rules)
    return value * OBJECTIVE_FACTOR if is_objective(piece.camp, known.cell, game, cells) else value


@kernel
def can_aim(i: PieceIndex, j: PieceIndex, game: GameRecord, pieces: Pieces) -> bool:
    """Piece i itself sees enemy j, and j is not in close combat."""
    return sees_itself(pieces[i], pieces[j]) and not in_fight(game, pieces[j])


@kernel
def best_shot(
    i: PieceIndex, only: PieceIndex, settled: bool, allotted: Rows,
    game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord, cells: Cells,
) -> tuple[float, PieceIndex, int]:  # fmt: skip
    """The shot of greatest value that piece i may fire in this step, or might fire if it stood.

    Args:
        i: the shooter.
        only: an enemy to choose, or NO_PIECE for any that i itself sees.
        settled: True leaves motion, cool-down and transitions aside: what a stop would be worth.
        allotted: losses that other shots of this step are expected to cause, [P].

    Returns:
        Value in points (0: none), target (NO_PIECE) and weapon (NO_WEAPON).
    """
    piece = pieces[i]
    best, target, with_weapon = 0.0, NO_PIECE, NO_WEAPON
    if piece.sees == 0 or not on_map(piece) or in_fight(game, piece):
        return best, target, with_weapon
    if (piece.cool_ends != NEVER and not settled) or is_pinned(piece):
        return best, target, with_weapon
    enemy = CampIndex(1 - piece.camp)
    for j in piece_range(first_piece(enemy, game), end_piece(enemy, game)):
        if (only != NO_PIECE and j != only) or not can_aim(i, j, game, pieces):
            continue
        for weapon in range(rules.pool.shape[1]):
            if weapon_ammo(piece, weapon, rules) == 0:
                continue
            if not settled and may_fire_now(piece, weapon, rules) != Code.OK:
                continue
            value = shot_value(i, j, weapon, settled, allotted, game, pieces, memory, rules, cells)
            if value > best:
                best, target, with_weapon = value, j, weapon
    return best, target, with_weapon


@kernel
def is_pinned(piece: PieceRecord) -> bool:
    """Suppressed soldiers cannot fire."""
    return piece.suppressed == 1 and piece.kind == PieceType.SOLDIER


@kernel
def expect_loss(
    i: PieceIndex, j: PieceIndex, weapon: int, allotted: Rows, game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord,
    cells: Cells,
) -> None:  # fmt: skip
    """Allot the median loss of a shot of piece i to enemy j, so that the next shooter knows of it."""
    piece = pieces[i]
    known = memory[piece.camp, j]
    kind = pieces[j].kind
    level = level_from(weapon, piece.kind, piece.blood, piece.cell, kind, known.cell, rules, cells)
    mods = shooter_mods(piece, False, rules)
    mods += target_mods(piece.camp, j, game, pieces, memory, rules, cells)
    allotted[j] += median_loss(weapon, piece.blood, level, mods, kind, known.blood, rules)


@kernel
def may_guide(i: PieceIndex, game: GameRecord, pieces: Pieces) -> bool:
    """Piece i is ready to guide a missile, whatever the chariot and the target (section 4)."""
    piece = pieces[i]
    if piece.kind != PieceType.SOLDIER and piece.kind != PieceType.AEROCRAFT:
        return False
    ready = on_map(piece) and is_settled(piece) and not piece.suppressed and piece.cool_ends == NEVER
    return ready and not in_fight(game, piece)


@kernel
def may_launch(i: PieceIndex, c: PieceIndex, game: GameRecord, pieces: Pieces, rules: RulesRecord) -> bool:
    """Chariot c is ready to launch for guider i."""
    chariot = pieces[c]
    if chariot.kind != PieceType.CHARIOT or not on_map(chariot) or chariot.cool_ends != NEVER:
        return False
    if pieces[i].kind == PieceType.SOLDIER and pieces[i].home != c:
        return False
    if not is_settled(chariot) or in_fight(game, chariot):
        return False
    return weapon_ammo(chariot, Weapon.HEAVY, rules) > 0


@kernel
def slot_bit(piece: PieceRecord) -> np.uint64:
    """Bit of a piece in a set of pieces of its camp."""
    return np.uint64(1) << np.uint64(piece.slot)


@kernel
def is_taken(piece: PieceRecord, taken: np.uint64) -> bool:
    """Whether a piece is in a set of pieces of its camp."""
    return (taken & slot_bit(piece)) != np.uint64(0)


@kernel
def best_guided(
    i: PieceIndex, only: PieceIndex, taken: np.uint64, allotted: Rows,
    game: GameRecord, pieces: Pieces, memory: Memory, orders: Orders, rules: RulesRecord, cells: Cells,
) -> tuple[float, PieceIndex, PieceIndex]:  # fmt: skip
    """The guided shot of greatest value that piece i may order in this step (section 8).

    Args:
        i: the guider; `only` and `allotted` as in `best_shot`.
        taken: bit s: another order of this step lays hands on the camp's piece in slot s.

    Returns:
        Value in points (0: none), target and launching chariot (NO_PIECE).
    """
    best, target, launcher = 0.0, NO_PIECE, NO_PIECE
    if pieces[i].sees == 0 or not may_guide(i, game, pieces):
        return best, target, launcher
    camp = pieces[i].camp
    for c in piece_range(first_piece(camp, game), end_piece(camp, game)):
        free = orders[c].kind == Action.NULL and not is_taken(pieces[c], taken)
        if not free or not may_launch(i, c, game, pieces, rules):
            continue
        for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
            vehicle = pieces[j].kind == PieceType.TANK or pieces[j].kind == PieceType.CHARIOT
            if not vehicle or (only != NO_PIECE and j != only) or not can_aim(i, j, game, pieces):
                continue
            value = shot_value(c, j, Weapon.HEAVY, True, allotted, game, pieces, memory, rules, cells)
            if value > best:
                best, target, launcher = value, j, c
    return best, target, launcher
