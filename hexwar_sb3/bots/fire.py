"""Fire that takes two: guided missiles, and mortar rounds with somebody to see them land.

Direct fire is the executor's; a bot only sets its style in the missions.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import BotConfig, Style
from hexwar_sb3.bots.records import BrainRecord
from hexwar_sb3.engine.pieces import is_settled, on_map, weapon_ammo
from hexwar_sb3.engine.records import (
    NEVER,
    NO_CELL,
    NO_PIECE,
    ROUND_FLYING,
    GameRecord,
    Memory,
    Orders,
    PieceRecord,
    Pieces,
    Rounds,
)
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.bombard import mortar_value
from hexwar_sb3.tasks.known import end_piece, first_piece, is_known
from hexwar_sb3.tasks.phi import give, give_guided
from hexwar_sb3.tasks.shots import best_guided, best_shot, expect_loss


@kernel
def guide_missiles(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, orders: Orders, brain: BrainRecord, rules: RulesRecord,
    cells: Cells, config: BotConfig,
) -> None:  # fmt: skip
    """Pair guiders (aerocraft first) with idle chariots, unless a direct shot is about as good."""
    first, end = first_piece(camp, game), end_piece(camp, game)
    taken = np.uint64(0)
    for flying in (True, False):
        for i in piece_range(first, end):
            if pieces[i].sees == 0 or (pieces[i].kind == PieceType.AEROCRAFT) != flying:
                continue
            value, target, chariot = best_guided(
                i, NO_PIECE, taken, brain.allotted, game, pieces, memory, orders, rules, cells
            )
            if target == NO_PIECE or value < style.guide_value:
                continue
            if own_shots_do(
                i, chariot, config.guide_share * value, brain, game, pieces, memory, rules, cells
            ):
                continue
            if give_guided(i, target, chariot, game, pieces, orders, rules, cells):
                expect_loss(chariot, target, Weapon.HEAVY, brain.allotted, game, pieces, memory, rules, cells)


@kernel
def own_shots_do(
    i: PieceIndex, chariot: PieceIndex, value: float, brain: BrainRecord, game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord,
    cells: Cells,
) -> bool:  # fmt: skip
    """The chariot's own shot, or the guider's, is worth at least so much."""
    direct, _, _ = best_shot(chariot, NO_PIECE, False, brain.allotted, game, pieces, memory, rules, cells)
    if direct >= value:
        return True
    own, _, _ = best_shot(i, NO_PIECE, False, brain.allotted, game, pieces, memory, rules, cells)
    return own >= value


@kernel
def lob_rounds(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, orders: Orders, rules: RulesRecord, cells: Cells, config: BotConfig,
) -> None:  # fmt: skip
    """Fire the mortars of idle chariots at enemies that stand still."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if orders[i].kind != Action.NULL or not may_lob(pieces[i], rules):
            continue
        cell = best_aim(style, i, camp, game, pieces, memory, rounds, rules, cells, config)
        if cell != NO_CELL:
            give(i, Action.INDIRECT_SHOOT, NO_PIECE, cell, game, pieces, orders, rules, cells)


@kernel
def may_lob(piece: PieceRecord, rules: RulesRecord) -> bool:
    """A chariot with a round ready and nothing better to shoot at."""
    if piece.kind != PieceType.CHARIOT or not on_map(piece) or piece.suppressed or not is_settled(piece):
        return False
    if piece.mortar_ends != NEVER or piece.cool_ends != NEVER:
        return False
    return weapon_ammo(piece, Weapon.MORTAR, rules) > 0


@kernel
def best_aim(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, rules: RulesRecord,
    cells: Cells, config: BotConfig,
) -> CellIndex:  # fmt: skip
    """Cell of the enemy that a round of chariot i is worth most on; NO_CELL: none is worth it."""
    best, aim = float(style.mortar_value), NO_CELL
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        if not is_known(known) or pieces[j].kind == PieceType.AEROCRAFT:
            continue
        last_seen = game.tick if known.seen else known.tick
        still = last_seen - known.still_since >= config.still_ticks
        if not still or game.tick - last_seen > config.still_ticks:
            continue
        apart = cells_apart(cells, pieces[i].cell, known.cell)
        if apart < rules.mortar_min_cells or apart > rules.mortar_max_cells:
            continue
        if is_under_fire(known.cell, camp, rounds) or own_near(
            known.cell, config.safe_cells, camp, game, pieces, cells
        ):
            continue
        value = mortar_value(i, known.cell, known.seen == 1, game, pieces, memory, rules, cells)
        if value > best:
            best, aim = value, CellIndex(known.cell)
    return aim


@kernel
def is_under_fire(cell: CellIndex, camp: CampIndex, rounds: Rounds) -> bool:
    """A round of the camp is in the air for this cell."""
    for r in range(rounds.size):
        if rounds[r].status == ROUND_FLYING and rounds[r].camp == camp and rounds[r].cell == cell:
            return True
    return False


@kernel
def own_near(
    cell: CellIndex, within: int, camp: CampIndex, game: GameRecord, pieces: Pieces, cells: Cells
) -> bool:
    """An own ground piece is within some cells of a cell."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        piece = pieces[i]
        if (
            piece.blood > 0
            and piece.kind != PieceType.AEROCRAFT
            and cells_apart(cells, piece.cell, cell) <= within
        ):
            return True
    return False
