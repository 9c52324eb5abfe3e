"""Chariots and their soldiers: carrying, setting down, picking up (bots.md, section 1)."""

from __future__ import annotations

from hexwar_sb3.bots.config import BotConfig, Style
from hexwar_sb3.bots.missions import board, give_mission
from hexwar_sb3.bots.points import may_enter
from hexwar_sb3.bots.posts import choose_post
from hexwar_sb3.bots.records import NOBODY, AtlasRecord, BrainRecord
from hexwar_sb3.bots.weigh import enemy_near
from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, PointIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import Missions, TaskKind
from hexwar_sb3.tasks.travel import travel_ticks


@kernel
def carry(
    style: Style, i: PieceIndex, k: PointIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Bring the soldier to its point if that is quiet, else to a post from which it can guide."""
    first = first_piece(camp, game)
    point = game.point_cell[k]
    quiet = not enemy_near(point, style.drop_cells, camp, pieces, memory, brain, cells)
    brain.dropped_for[SlotIndex(pieces[i].passenger - first)] = k + 1
    if (
        brain.taker[k] == i - first
        and quiet
        and may_enter(style, k, camp, game, pieces, memory, brain, rules, cells)
    ):
        brain.post[SlotIndex(i - first)] = NO_CELL
        give_mission(style, i, TaskKind.HOLD, point, game, missions)
    elif game.point_owner[k] == camp and quiet and brain.keeper[k] == NOBODY:
        brain.post[SlotIndex(i - first)] = NO_CELL
        give_mission(style, i, TaskKind.DROP, point, game, missions)
    else:
        cell = choose_post(
            style, i, NO_PIECE, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
        )
        brain.post[SlotIndex(i - first)] = cell
        give_mission(style, i, TaskKind.DROP, cell, game, missions)


@kernel
def ride(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, eta: TravelTimes, config: BotConfig,
) -> bool:  # fmt: skip
    """A soldier far from its work and its idle chariot meet where the soldier stands; False: no such business."""
    piece = pieces[i]
    if piece.kind == PieceType.SOLDIER:
        if not wants_ride(i, camp, game, pieces, memory, brain, rules, cells, eta, config):
            return False
        if pieces[piece.home].cell == piece.cell:
            board(style, i, piece.home, game, missions)
        else:
            give_mission(style, i, TaskKind.HOLD, piece.cell, game, missions)
        return True
    if piece.kind != PieceType.CHARIOT or piece.passenger != NO_PIECE:
        return False
    for s in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if pieces[s].home == i and wants_ride(
            s, camp, game, pieces, memory, brain, rules, cells, eta, config
        ):
            brain.post[SlotIndex(i - first_piece(camp, game))] = NO_CELL
            give_mission(style, i, TaskKind.HOLD, pieces[s].cell, game, missions)
            return True
    return False


@kernel
def wants_ride(
    s: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord, rules: RulesRecord, cells: Cells,
    eta: TravelTimes, config: BotConfig,
) -> bool:  # fmt: skip
    """Soldier s has nobody to watch here, and work that is too far to walk to; its chariot is free."""
    soldier = pieces[s]
    if soldier.kind != PieceType.SOLDIER or not on_map(soldier) or soldier.suppressed:
        return False
    chariot = pieces[soldier.home]
    if not on_map(chariot) or chariot.passenger != NO_PIECE or chariot.suppressed:
        return False
    slot = SlotIndex(s - first_piece(camp, game))
    k = brain.point[slot]
    point = game.point_cell[k]
    needed = game.point_owner[k] == camp and brain.keeper[k] == NOBODY
    if brain.dropped_for[slot] == k + 1 and not needed:
        return False
    if cells_apart(cells, soldier.cell, point) <= config.walk_cells:
        return False
    if enemy_near(soldier.cell, config.ride_clear_cells, camp, pieces, memory, brain, cells):
        return False
    ticks = travel_ticks(PieceType.CHARIOT, chariot.cell, soldier.cell, rules, cells, eta)
    ticks += travel_ticks(PieceType.CHARIOT, soldier.cell, point, rules, cells, eta)
    if enemy_near(point, config.ride_clear_cells, camp, pieces, memory, brain, cells):
        return False
    return ticks + config.ride_spare_ticks < game.end_tick - game.tick
