"""Which order is legal, and if not, why (rule book, section 4). Reads the state only.

One function an action; each returns a `Code`, OK where the order may be given.
"""

from __future__ import annotations

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.fire import attack_level
from hexwar_sb3.engine.pieces import (
    count_in,
    has_path,
    hop_from,
    hop_progress,
    in_fight,
    is_busy,
    is_ground,
    is_settled,
    on_map,
    target_class,
    weapon_ammo,
)
from hexwar_sb3.engine.records import NEVER, NO_PIECE, NO_POINT, GameRecord, OrderRecord, PieceRecord, Pieces
from hexwar_sb3.engine.sight import sees_itself
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import NO_POOL, RulesRecord
from hexwar_sb3.rules.enums import Action, PieceType, TargetClass, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, PointIndex, point_range


@kernel
def order_code(
    i: PieceIndex, order: OrderRecord, game: GameRecord, pieces: Pieces, rules: RulesRecord, cells: Cells
) -> int:
    """Code of one order in the present state; conflicts inside a camp are found later."""
    kind = order.kind
    piece = pieces[i]
    if kind == Action.NULL:
        return Code.OK
    if game.over:
        return Code.GAME_OVER
    if piece.blood == 0:
        return Code.DEAD
    if piece.carrier != NO_PIECE:
        return Code.ABOARD
    if kind == Action.MOVE:
        return move_code(piece, order, game, pieces, rules, cells)
    if in_fight(game, piece):
        return Code.CLOSE_COMBAT
    if kind == Action.STOP:
        return Code.OK if has_path(piece) else Code.NO_PATH
    if kind == Action.HIDE:
        return hide_code(piece)
    if kind == Action.OCCUPY:
        return occupy_code(piece, game)
    if kind == Action.SHOOT:
        return shoot_code(i, order.target, order.weapon, game, pieces, rules, cells)
    if kind == Action.GUIDE_SHOOT:
        return guide_code(i, order.partner, order.target, game, pieces, rules, cells)
    if kind == Action.INDIRECT_SHOOT:
        return indirect_code(piece, order.cell, rules, cells)
    if kind == Action.GET_ON:
        return get_on_code(piece, order.target, pieces)
    if kind == Action.GET_OFF:
        return get_off_code(i, order.target, pieces, rules)
    if kind == Action.DECOMPRESS:
        return decompress_code(piece, game, rules)
    return Code.ORDER_UNKNOWN


@kernel
def move_code(
    piece: PieceRecord, order: OrderRecord, game: GameRecord, pieces: Pieces, rules: RulesRecord, cells: Cells
) -> int:
    """May the piece start on this path?"""
    if is_busy(piece):
        return Code.BUSY
    if has_path(piece):
        return Code.MOVING
    if piece.kind == PieceType.SOLDIER and piece.suppressed:
        return Code.SUPPRESSED
    if order.path_len == 0:
        return Code.EMPTY_PATH
    if order.path_len > min(int(rules.path_limit), order.path.size):
        return Code.PATH_TOO_LONG
    cell = piece.cell
    for k in range(int(order.path_len)):
        if order.path[k] > 5 or hop_from(piece.kind, cell, order.path[k], rules, cells) == 0:
            return Code.NO_HOP
        cell = cells[cell].neighbour[order.path[k]]
    if in_fight(game, piece):
        first = cells[piece.cell].neighbour[order.path[0]]
        if count_in(pieces, CampIndex(1 - piece.camp), first) > 0:
            return Code.EXIT_BLOCKED
    return Code.OK


@kernel
def hide_code(piece: PieceRecord) -> int:
    """May the piece begin to hide?"""
    if not is_ground(piece):
        return Code.NOT_GROUND
    if has_path(piece):
        return Code.MOVING
    if is_busy(piece):
        return Code.BUSY
    if piece.suppressed:
        return Code.SUPPRESSED
    if piece.hidden:
        return Code.ALREADY_HIDDEN
    return Code.OK


@kernel
def point_at(cell: CellIndex, game: GameRecord) -> PointIndex:
    """Number of the control point in a cell; NO_POINT where there is none."""
    for k in point_range(game.n_points):
        if game.point_cell[k] == cell:
            return k
    return NO_POINT


@kernel
def occupy_code(piece: PieceRecord, game: GameRecord) -> int:
    """Place, camp and progress only; enemies are looked for in the step itself."""
    if not is_ground(piece):
        return Code.NOT_GROUND
    if hop_progress(piece, game.tick) > 0:
        return Code.BETWEEN_CELLS
    k = point_at(piece.cell, game)
    if k < 0:
        return Code.NOT_CONTROL_POINT
    if game.point_owner[k] == piece.camp:
        return Code.OWN_POINT
    return Code.OK


@kernel
def target_code(i: PieceIndex, t: PieceIndex, game: GameRecord, pieces: Pieces) -> int:
    """May piece i aim at piece t at all: an enemy, there, seen by i itself, not in close combat?"""
    if t < 0 or t >= pieces.size:
        return Code.TARGET_GONE
    if pieces[t].camp == pieces[i].camp:
        return Code.NOT_ENEMY
    if not on_map(pieces[t]) or not sees_itself(pieces[i], pieces[t]):
        return Code.TARGET_GONE
    if in_fight(game, pieces[t]):
        return Code.TARGET_IN_FIGHT
    return Code.OK


@kernel
def range_code(
    weapon: int, shooter: PieceRecord, target: PieceRecord, rules: RulesRecord, cells: Cells
) -> int:
    """Distance and attack level of a shot."""
    apart = cells_apart(cells, shooter.cell, target.cell)
    table = rules.level[weapon, target_class(target.kind), min(int(shooter.blood), rules.level.shape[2] - 1)]
    if apart >= table.size or table[apart] == 0:
        return Code.OUT_OF_RANGE
    if attack_level(weapon, shooter, target, rules, cells) < 1:
        return Code.LEVEL_ZERO
    return Code.OK


@kernel
def may_fire_now(piece: PieceRecord, weapon: int, rules: RulesRecord) -> int:
    """Settled, or a type that fires on the move with the weapon for it."""
    if piece.kind == PieceType.SOLDIER and piece.suppressed:
        return Code.SUPPRESSED
    if is_settled(piece):
        return Code.OK
    on_the_move = rules.moving_fire[piece.kind] == 1 and weapon == rules.moving_weapon
    if on_the_move:
        halted = piece.stop_ends != NEVER and piece.stop_forced == 1 and not has_path(piece)
        if halted or piece.board_ends != NEVER or piece.decompress_ends != NEVER:
            return Code.BUSY
        return Code.OK
    return Code.MOVING if has_path(piece) or piece.stop_ends != NEVER else Code.BUSY


@kernel
def shoot_code(
    i: PieceIndex,
    t: PieceIndex,
    weapon: int,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """May piece i fire this weapon at piece t?"""
    piece = pieces[i]
    if weapon < 0 or weapon >= rules.pool.shape[1] or rules.pool[piece.kind, weapon] == NO_POOL:
        return Code.NOT_ARMED
    if weapon_ammo(piece, weapon, rules) == 0:
        return Code.NO_AMMO
    if piece.cool_ends != NEVER:
        return Code.COOLING
    code = may_fire_now(piece, weapon, rules)
    if code != Code.OK:
        return code
    code = target_code(i, t, game, pieces)
    if code != Code.OK:
        return code
    return range_code(weapon, piece, pieces[t], rules, cells)


@kernel
def guide_code(
    i: PieceIndex,
    c: PieceIndex,
    t: PieceIndex,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """May piece i guide a heavy missile of chariot c to piece t (section 8)?"""
    piece = pieces[i]
    if piece.kind != PieceType.SOLDIER and piece.kind != PieceType.AEROCRAFT:
        return Code.WRONG_TYPE
    if c < 0 or c >= pieces.size or pieces[c].camp != piece.camp or pieces[c].kind != PieceType.CHARIOT:
        return Code.WRONG_PARTNER
    if piece.kind == PieceType.SOLDIER and piece.home != c:
        return Code.WRONG_PARTNER
    if piece.suppressed:
        return Code.SUPPRESSED
    if not is_settled(piece):
        return Code.MOVING
    if piece.cool_ends != NEVER:
        return Code.COOLING
    code = target_code(i, t, game, pieces)
    if code != Code.OK:
        return code
    if target_class(pieces[t].kind) != TargetClass.VEHICLE:
        return Code.WRONG_TYPE
    chariot = pieces[c]
    if (
        not on_map(chariot)
        or not is_settled(chariot)
        or chariot.cool_ends != NEVER
        or in_fight(game, chariot)
    ):
        return Code.PARTNER_BUSY
    if weapon_ammo(chariot, Weapon.HEAVY, rules) == 0:
        return Code.NO_AMMO
    return range_code(Weapon.HEAVY, chariot, pieces[t], rules, cells)


@kernel
def indirect_code(piece: PieceRecord, cell: CellIndex, rules: RulesRecord, cells: Cells) -> int:
    """May the chariot fire its mortar at a cell (section 9)?"""
    if rules.pool[piece.kind, Weapon.MORTAR] == NO_POOL:
        return Code.WRONG_TYPE
    if piece.suppressed:
        return Code.SUPPRESSED
    if not is_settled(piece):
        return Code.MOVING
    if weapon_ammo(piece, Weapon.MORTAR, rules) == 0:
        return Code.NO_AMMO
    if piece.mortar_ends != NEVER:
        return Code.COOLING
    if cell < 0 or cell >= cells.size or cells[cell].playable == 0:
        return Code.BAD_CELL
    apart = cells_apart(cells, piece.cell, cell)
    if apart < rules.mortar_min_cells or apart > rules.mortar_max_cells:
        return Code.OUT_OF_RANGE
    return Code.OK


@kernel
def get_on_code(piece: PieceRecord, c: PieceIndex, pieces: Pieces) -> int:
    """May the soldier board chariot c?"""
    if piece.kind != PieceType.SOLDIER:
        return Code.WRONG_TYPE
    if c < 0 or c >= pieces.size or pieces[c].kind != PieceType.CHARIOT or pieces[c].camp != piece.camp:
        return Code.WRONG_PARTNER
    chariot = pieces[c]
    if not on_map(chariot) or chariot.cell != piece.cell:
        return Code.WRONG_PARTNER
    if chariot.passenger != NO_PIECE:
        return Code.CARRIER_FULL
    if piece.suppressed:
        return Code.SUPPRESSED
    if not is_settled(piece):
        return Code.MOVING
    if chariot.suppressed or not is_settled(chariot):
        return Code.PARTNER_BUSY
    return Code.OK


@kernel
def get_off_code(c: PieceIndex, p: PieceIndex, pieces: Pieces, rules: RulesRecord) -> int:
    """May chariot c set down passenger p?"""
    chariot = pieces[c]
    if chariot.kind != PieceType.CHARIOT:
        return Code.WRONG_TYPE
    if p < 0 or chariot.passenger != p:
        return Code.WRONG_PARTNER
    if chariot.suppressed:
        return Code.SUPPRESSED
    if not is_settled(chariot):
        return Code.MOVING
    if count_in(pieces, chariot.camp, chariot.cell) >= rules.stack_limit:
        return Code.CELL_FULL
    return Code.OK


@kernel
def decompress_code(piece: PieceRecord, game: GameRecord, rules: RulesRecord) -> int:
    """May the piece work itself free of suppression?"""
    if not piece.suppressed:
        return Code.NOT_SUPPRESSED
    if piece.keep_ends - game.tick <= rules.decompress_above_ticks:
        return Code.TOO_LATE_TO_DECOMPRESS
    if hop_progress(piece, game.tick) > 0:
        return Code.BETWEEN_CELLS
    if piece.stop_ends != NEVER:
        return Code.MOVING
    if is_busy(piece):
        return Code.BUSY
    return Code.OK
