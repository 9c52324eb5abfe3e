"""Who works for which control point: takers of foreign points, keepers of own ones."""

from __future__ import annotations

from hexwar_sb3.bots.config import BotConfig, Style
from hexwar_sb3.bots.records import NOBODY, AtlasRecord, BrainRecord
from hexwar_sb3.bots.weigh import enemy_near, known_power, own_power
from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, PointIndex, SlotIndex, piece_range, point_range, slot_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks


@kernel
def first_points(
    camp: CampIndex, game: GameRecord, pieces: Pieces, brain: BrainRecord, atlas: AtlasRecord
) -> None:
    """Deal the pieces of each type out to the points, the most valuable point first; soldiers follow their chariot."""
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        same = 0
        for other in piece_range(first, i):
            if pieces[other].kind == pieces[i].kind:
                same += 1
        brain.point[SlotIndex(i - first)] = atlas.rank[same % max(1, game.n_points)]
        brain.post[SlotIndex(i - first)] = NO_CELL
    for i in piece_range(first, end_piece(camp, game)):
        if pieces[i].home >= 0:
            brain.point[SlotIndex(i - first)] = brain.point[SlotIndex(pieces[i].home - first)]


@kernel
def is_safe(
    k: PointIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    brain: BrainRecord,
    cells: Cells,
    config: BotConfig,
) -> bool:
    """An own point with no known enemy around."""
    if game.point_owner[k] != camp:
        return False
    return not enemy_near(game.point_cell[k], config.safe_point_cells, camp, pieces, memory, brain, cells)


@kernel
def move_idle(
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    brain: BrainRecord,
    cells: Cells,
    config: BotConfig,
    atlas: AtlasRecord,
) -> None:
    """Pieces of a safe point, its keeper left out, go to work for the best point that is not safe."""
    for n in point_range(game.n_points):
        k = atlas.rank[n]
        if is_safe(k, camp, game, pieces, memory, brain, cells, config):
            continue
        for slot in slot_range(end_piece(camp, game) - first_piece(camp, game)):
            now = brain.point[slot]
            if (
                now != k
                and brain.keeper[now] != slot
                and is_safe(now, camp, game, pieces, memory, brain, cells, config)
            ):
                brain.point[slot] = k
        return


@kernel
def choose_people(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, brain: BrainRecord, rules: RulesRecord, cells: Cells, eta: TravelTimes,
    config: BotConfig,
) -> None:  # fmt: skip
    """Name the taker of every foreign point and the keeper of every own one."""
    for k in point_range(game.n_points):
        brain.taker[k], brain.keeper[k] = NOBODY, NOBODY
        if game.point_owner[k] == camp:
            brain.keeper[k] = best_keeper(style, k, camp, game, pieces, rules, cells, config)
        else:
            brain.taker[k] = best_taker(style, k, camp, game, pieces, brain, rules, cells, eta)


@kernel
def best_keeper(
    style: Style,
    k: PointIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
    config: BotConfig,
) -> SlotIndex:
    """Slot of the ground piece of least value that is at an own point, soldiers first; NOBODY."""
    best, least = NOBODY, 0
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        piece = pieces[i]
        if not on_map(piece) or piece.kind == PieceType.AEROCRAFT or piece.passenger >= 0:
            continue
        if piece.kind != PieceType.SOLDIER and not style.keep_vehicles:
            continue
        if cells_apart(cells, piece.cell, game.point_cell[k]) > config.keeper_cells:
            continue
        value = int(rules.value[piece.kind]) * piece.blood
        if piece.kind == PieceType.SOLDIER:
            value = 0
        if best == NOBODY or value < least:
            best, least = SlotIndex(i - first), value
    return best


@kernel
def best_taker(
    style: Style,
    k: PointIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    brain: BrainRecord,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
) -> SlotIndex:
    """Slot of the piece that takes a foreign point: the quickest, by the style's delays; NOBODY."""
    best, least = NOBODY, float(UNREACHABLE)
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        piece = pieces[i]
        if not on_map(piece) or piece.kind == PieceType.AEROCRAFT or brain.point[SlotIndex(i - first)] != k:
            continue
        ticks = travel_ticks(piece.kind, piece.cell, game.point_cell[k], rules, cells, eta)
        cost = ticks + style.take_delay[piece.kind]
        if piece.passenger != NO_PIECE:
            cost += style.carry_delay
        if piece.kind == PieceType.SOLDIER and ticks > style.walk_ticks:
            continue
        if cost < least and ticks < game.end_tick - game.tick:
            best, least = SlotIndex(i - first), cost
    return best


@kernel
def may_enter(
    style: Style, k: PointIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord, rules: RulesRecord,
    cells: Cells,
) -> bool:  # fmt: skip
    """The camp is strong enough around a foreign point to go in, or it is time to."""
    if brain.rush:
        return True
    cell = game.point_cell[k]
    enemies = known_power(cell, style.around_cells, camp, pieces, memory, brain, rules, cells)
    if enemies <= 0.0:
        return True
    own = own_power(cell, style.own_cells, camp, game, pieces, rules, cells)
    return own >= style.enter_ratio * enemies
