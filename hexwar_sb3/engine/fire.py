"""Direct, guided and close fire (rule book, sections 7, 8, 10): from a shot to its result.

Every function here reads the state at the start of the step; results are collected in the
pieces' scratch fields and applied together (`apply_results`), so nobody fires first.
"""

from __future__ import annotations

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.dice import die, two_dice
from hexwar_sb3.engine.events import note, note_shot
from hexwar_sb3.engine.pieces import count_in, in_motion, is_ground, target_class
from hexwar_sb3.engine.records import GameRecord, Log, Orders, PieceRecord, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import NO_EFFECT, RulesRecord
from hexwar_sb3.rules.enums import Action, Dice, TargetClass, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex, piece_range


@kernel
def attack_level(
    weapon: int, shooter: PieceRecord, target: PieceRecord, rules: RulesRecord, cells: Cells
) -> int:
    """Level of a shot at the target where it is, height correction included; 0 = no shot."""
    return level_between(weapon, shooter, shooter.cell, target.kind, target.cell, rules, cells)


@kernel
def level_between(
    weapon: int,
    shooter: PieceRecord,
    shooter_cell: CellIndex,
    target_kind: int,
    target_cell: CellIndex,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Level of a shot from one cell into another, 0 = no shot."""
    apart = cells_apart(cells, shooter_cell, target_cell)
    table = rules.level[weapon, target_class(target_kind), min(int(shooter.blood), rules.level.shape[2] - 1)]
    if apart >= table.size:
        return 0
    level = int(table[apart])
    if level == 0:
        return 0
    if is_ground(shooter) and target_class(target_kind) != TargetClass.AEROCRAFT:
        level += height_correction(cells[target_cell].level - cells[shooter_cell].level, apart, rules)
    return max(level, 0)


@kernel
def height_correction(uphill: int, apart: int, rules: RulesRecord) -> int:
    """Loss of level for shooting uphill by this many grade steps."""
    if uphill <= 0 or apart < 1 or apart >= rules.height.shape[1]:
        return 0
    return int(rules.height[min(uphill, rules.height.shape[0] - 1), apart])


@kernel
def shot_mods(
    shooter: PieceRecord, target: PieceRecord, pieces: Pieces, rules: RulesRecord, cells: Cells
) -> int:
    """Sum of the correction's modifiers for a shot."""
    mods = 0
    if shooter.suppressed:
        mods += rules.mod_shooter_suppressed
    if in_motion(shooter):
        mods += rules.mod_shooter_moving
    if cells[target.cell].concealed:
        mods += rules.mod_target_concealed
    if target.hidden:
        mods += rules.mod_target_hidden
    if in_motion(target):
        mods += rules.mod_target_moving
    if count_in(pieces, target.camp, target.cell) >= 2:
        mods += rules.mod_target_stacked
    return int(mods)


@kernel
def clamp(x: int, low: int, high: int) -> int:
    """X within low..high."""
    return min(max(x, low), high)


@kernel
def vehicle_correction(modified_roll: int, armour: int, rules: RulesRecord) -> int:
    """Correction of a result on a vehicle; the table starts at a modified roll of -3."""
    last = rules.vehicle_correction.shape[0] - 1
    return int(rules.vehicle_correction[clamp(modified_roll + 3, 0, last), armour])


@kernel
def soldier_correction(modified_roll: int, rules: RulesRecord) -> int:
    """Correction of a result on soldiers."""
    return int(rules.soldier_correction[clamp(modified_roll, 0, rules.soldier_correction.size - 1)])


@kernel
def add_result(target: PieceRecord, result: int) -> None:
    """Collect one result for the end of the fire phase; losses add up."""
    if result == NO_EFFECT:
        return
    target.hit_now = 1
    if result == 0:
        target.zero_now = 1
    target.losses_now = min(int(target.losses_now) + result, 100)


@kernel
def resolve_shot(
    event: int, actor: PieceIndex, s: PieceIndex, t: PieceIndex, weapon: int, exit_shot: bool, game: GameRecord, pieces: Pieces,
    log: Log, rules: RulesRecord, cells: Cells,
) -> None:  # fmt: skip
    """Throw the dice of one shot of piece s at piece t and collect the result.

    `actor` is logged as who fired: the guider of a guided shot, else s. Exit shots have dice of their own.
    """
    shooter = pieces[s]
    target = pieces[t]
    tick = game.tick
    level = attack_level(weapon, shooter, target, rules, cells)
    mods = shot_mods(shooter, target, pieces, rules, cells)
    roll_kind = Dice.EXIT_SHOT if exit_shot else Dice.DIRECT
    corr_kind = Dice.EXIT_SHOT if exit_shot else Dice.DIRECT_CORRECTION
    corr_draw = 2 if exit_shot else 0
    roll2 = 0
    corr = 0
    kind = target_class(target.kind)
    if kind == TargetClass.AEROCRAFT:
        roll = two_dice(game, tick, Dice.AIR, shooter, target, 0)
        raw = int(target.blood) if level >= rules.air_kill_level[roll] else NO_EFFECT
    elif kind == TargetClass.SOLDIER:
        roll = two_dice(game, tick, roll_kind, shooter, target, 0)
        raw = int(rules.soldier_result[roll, level])
        roll2 = die(game, tick, corr_kind, shooter, target, corr_draw)
        corr = soldier_correction(roll2 + mods, rules)
    else:
        roll = two_dice(game, tick, roll_kind, shooter, target, 0)
        raw = int(
            rules.vehicle_result[
                roll, rules.column[min(int(shooter.blood), rules.column.shape[0] - 1), level]
            ]
        )
        if weapon == Weapon.SMALL:
            raw = int(rules.soldier_result[roll, level])
        roll2 = two_dice(game, tick, corr_kind, shooter, target, corr_draw)
        corr = vehicle_correction(roll2 + mods, rules.armour[target.kind], rules)
    result = max(NO_EFFECT, raw + corr)
    add_result(target, result)
    note(game, log, event, actor, t, target.cell, s)
    apart = cells_apart(cells, shooter.cell, target.cell)
    note_shot(game, log, weapon, level, roll, raw, roll2, mods, corr, result, apart)


@kernel
def fire_orders(
    game: GameRecord, pieces: Pieces, orders: Orders, log: Log, rules: RulesRecord, cells: Cells
) -> None:
    """Throw the dice of every shot that was ordered; nothing changes but the collected results."""
    for i in piece_range(orders.size):
        order = orders[i]
        if order.code != Code.OK:
            continue
        if order.kind == Action.SHOOT:
            resolve_shot(Event.SHOT, i, i, order.target, order.weapon, False, game, pieces, log, rules, cells)
        elif order.kind == Action.GUIDE_SHOOT:
            resolve_shot(
                Event.GUIDED, i, order.partner, order.target, Weapon.HEAVY, False, game, pieces, log,
                rules, cells,
            )  # fmt: skip
