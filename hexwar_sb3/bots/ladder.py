"""The simpler players: constant plans, written or drawn, "nearest", "defender". They think in tasks, once every thought."""

from __future__ import annotations

from hexwar_sb3.bots.drawn_records import CharacterRecord
from hexwar_sb3.bots.records import AtlasRecord, BrainRecord
from hexwar_sb3.bots.registry import Bot, Duty
from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.engine.score import points_held
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, SlotIndex, piece_range, point_range
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.known import can_hurt, end_piece, first_piece, is_known
from hexwar_sb3.tasks.records import Missions, TaskKind
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks


@kernel
def climb(
    bot: int, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord, rules: RulesRecord,
    cells: Cells, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Give every piece of a simple player its task."""
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        if not on_map(pieces[i]):
            continue
        slot, hides = SlotIndex(i - first), bot == Bot.DEFENDER
        if bot == Bot.NEAREST or bot == Bot.DEFENDER:
            own = bot == Bot.DEFENDER and points_held(game, camp) > 0
            cell = nearest_point(i, own, camp, game, pieces, rules, cells, eta)
        elif bot == Bot.DRAWN_PLAN:
            cell, hides = drawn_point(slot, game, pieces[i], brain.drawn, atlas)
        else:
            cell = planned_point(bot, slot, game, pieces[i], atlas)
        if cell == NO_CELL:
            hunt(i, camp, game, pieces, memory, missions, rules, cells, atlas)
        elif pieces[i].passenger != NO_PIECE and pieces[i].cell == cell:
            assign(missions[i], TaskKind.DROP, NO_PIECE, cell, game.tick)
        elif hides and pieces[i].cell == cell:
            assign(missions[i], TaskKind.HIDE, NO_PIECE, cell, game.tick)
        else:
            assign(missions[i], TaskKind.HOLD, NO_PIECE, cell, game.tick)


@kernel
def planned_point(
    bot: int, slot: SlotIndex, game: GameRecord, piece: PieceRecord, atlas: AtlasRecord
) -> CellIndex:
    """Cell of the point that a constant plan sends a piece to; NO_CELL: it hunts."""
    if game.n_points == 0:
        return NO_CELL
    rank = 0
    if bot == Bot.HALF_HALF:
        rank = slot % 2
    elif bot == Bot.TWO_HOLD:
        if piece.kind == PieceType.TANK or piece.kind == PieceType.AEROCRAFT:
            return NO_CELL
        rank = slot % 2
    return CellIndex(game.point_cell[atlas.rank[min(rank, game.n_points - 1)]])


@kernel
def drawn_point(
    slot: SlotIndex, game: GameRecord, piece: PieceRecord, drawn: CharacterRecord, atlas: AtlasRecord
) -> tuple[CellIndex, bool]:
    """Cell that a drawn plan sends a piece to, NO_CELL if it hunts; and whether it hides there."""
    s = int(drawn.squad[slot])
    if game.tick < drawn.start[s]:
        return CellIndex(piece.cell), True
    if drawn.what[s, 0] == Duty.CHASE or game.n_points == 0:
        return NO_CELL, False
    return CellIndex(game.point_cell[atlas.rank[drawn.point[s]]]), bool(drawn.what[s, 0] == Duty.KEEP)


@kernel
def nearest_point(
    i: PieceIndex,
    own: bool,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
) -> CellIndex:
    """Cell of the control point that is quickest to reach, own or foreign; NO_CELL: there is none."""
    best, least = NO_CELL, UNREACHABLE
    piece = pieces[i]
    for k in point_range(game.n_points):
        if (game.point_owner[k] == camp) != own:
            continue
        cell = CellIndex(game.point_cell[k])
        ticks = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
        if ticks < least:
            best, least = cell, ticks
    return best


@kernel
def hunt(
    i: PieceIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
    atlas: AtlasRecord,
) -> None:
    """Attack the nearest known enemy that the piece can hurt; with none known, go to the main point."""
    prey, least = NO_PIECE, cells.size
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        if not is_known(memory[camp, j]) or not can_hurt(pieces[i], pieces[j].kind, rules):
            continue
        apart = cells_apart(cells, pieces[i].cell, memory[camp, j].cell)
        if apart < least:
            prey, least = j, apart
    if prey != NO_PIECE:
        assign(missions[i], TaskKind.ATTACK, prey, NO_CELL, game.tick)
    elif game.n_points > 0:
        assign(missions[i], TaskKind.HOLD, NO_PIECE, game.point_cell[atlas.rank[0]], game.tick)
