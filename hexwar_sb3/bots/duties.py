"""What each piece of the two full players does next: missions for the shared executor (bots.md)."""

from __future__ import annotations

from hexwar_sb3.bots.config import Style
from hexwar_sb3.bots.missions import give_mission
from hexwar_sb3.bots.points import may_enter
from hexwar_sb3.bots.posts import choose_post
from hexwar_sb3.bots.records import AtlasRecord, BrainRecord
from hexwar_sb3.bots.rides import carry, ride
from hexwar_sb3.bots.scout import scout
from hexwar_sb3.bots.weigh import enemy_near
from hexwar_sb3.engine.pieces import in_fight, is_settled
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, PieceRecord, Pieces, Rounds
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, SlotIndex, piece_range, point_range
from hexwar_sb3.tasks.known import end_piece, first_piece, ticks_left
from hexwar_sb3.tasks.phi import has_flying_round
from hexwar_sb3.tasks.records import Missions, TaskKind
from hexwar_sb3.tasks.travel import travel_ticks


@kernel
def order_duties(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Give every piece of the camp that is on the map its mission."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if takes_orders(pieces[i], game):
            order_duty(
                style, i, camp, game, pieces, memory, rounds, missions, brain, rules, cells, los, eta, atlas
            )


@kernel
def takes_orders(piece: PieceRecord, game: GameRecord) -> bool:
    """It lives, rides with nobody, and is in no close combat."""
    return piece.blood > 0 and piece.carrier == NO_PIECE and not in_fight(game, piece)


@kernel
def order_duty(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Give a piece its mission."""
    if pieces[i].kind == PieceType.AEROCRAFT:
        cell = scout(style, i, camp, game, pieces, memory, brain, rules, cells, los, atlas)
        give_mission(style, i, TaskKind.HOLD, cell, game, missions)
    elif recovers(i, camp, game, pieces, memory, brain, rules, cells):
        give_mission(style, i, TaskKind.RECOVER, NO_CELL, game, missions)
    elif has_flying_round(i, rounds):
        stay(style, i, camp, game, pieces, brain, missions)
    elif not ride(style, i, camp, game, pieces, memory, missions, brain, rules, cells, eta, atlas.config):
        work(style, i, camp, game, pieces, memory, missions, brain, rules, cells, los, eta, atlas)


@kernel
def recovers(
    i: PieceIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    brain: BrainRecord,
    rules: RulesRecord,
    cells: Cells,
) -> bool:
    """A suppressed piece that stands, sees nobody and has time to gain works itself free."""
    piece = pieces[i]
    if not piece.suppressed or not is_settled(piece) or piece.sees != 0:
        return False
    if ticks_left(piece.keep_ends, game.tick) <= rules.decompress_above_ticks:
        return False
    return not enemy_near(piece.cell, 2, camp, pieces, memory, brain, cells)


@kernel
def stay(
    style: Style,
    i: PieceIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    brain: BrainRecord,
    missions: Missions,
) -> None:
    """Stand where it is."""
    brain.post[SlotIndex(i - first_piece(camp, game))] = pieces[i].cell
    give_mission(style, i, TaskKind.HOLD, pieces[i].cell, game, missions)


@kernel
def work(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Take a point, keep one, carry a soldier, or fire from the best post."""
    slot = SlotIndex(i - first_piece(camp, game))
    if pieces[i].passenger != NO_PIECE:
        carry(
            style, i, brain.point[slot], camp, game, pieces, memory, missions, brain, rules, cells, los, eta,
            atlas,
        )  # fmt: skip
        return
    for p in point_range(game.n_points):
        if brain.keeper[p] == slot:
            brain.post[slot] = NO_CELL
            give_mission(style, i, TaskKind.HIDE, game.point_cell[p], game, missions)
            return
        if brain.taker[p] == slot and may_enter(style, p, camp, game, pieces, memory, brain, rules, cells):
            brain.post[slot] = NO_CELL
            give_mission(style, i, TaskKind.HOLD, game.point_cell[p], game, missions)
            return
    k = brain.point[slot]
    if brain.rush and game.point_owner[k] != camp and pieces[i].kind != PieceType.SOLDIER:
        brain.post[slot] = NO_CELL
        give_mission(style, i, TaskKind.HOLD, game.point_cell[k], game, missions)
        return
    if pieces[i].kind == PieceType.SOLDIER:
        give_mission(style, i, TaskKind.HIDE, pieces[i].cell, game, missions)
        return
    take_post(style, i, camp, game, pieces, memory, missions, brain, rules, cells, los, eta, atlas)


@kernel
def take_post(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Go to the best post and fire from it; hide there while nobody is in sight."""
    prey = NO_PIECE
    if style.hunt:
        prey = best_prey(i, camp, pieces, memory, brain, rules, cells, eta, atlas)
    cell = choose_post(style, i, prey, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas)
    brain.post[SlotIndex(i - first_piece(camp, game))] = cell
    hides = pieces[i].sees == 0 or style.always_hide
    give_mission(style, i, TaskKind.HIDE if hides else TaskKind.HOLD, cell, game, missions)


@kernel
def best_prey(
    i: PieceIndex, camp: CampIndex, pieces: Pieces, memory: Memory, brain: BrainRecord, rules: RulesRecord, cells: Cells, eta: TravelTimes, atlas: AtlasRecord
) -> PieceIndex:  # fmt: skip
    """Known enemy that is worth most for the way to it; NO_PIECE."""
    best, prey = 0.0, NO_PIECE
    for n in range(brain.n_foes):
        j = brain.foes[n]
        if pieces[j].kind == PieceType.AEROCRAFT:
            continue
        ticks = travel_ticks(pieces[i].kind, pieces[i].cell, memory[camp, j].cell, rules, cells, eta)
        value = brain.trust[j] * rules.value[pieces[j].kind] / (1.0 + ticks / atlas.config.hunt_ticks)
        if value > best:
            best, prey = value, j
    return prey
