"""The family "drawn": weighs as MA1 and MA2 do, by thresholds, squads, times and feints that are drawn."""

from __future__ import annotations

from hexwar_sb3.bots.duties import best_prey, order_duty, takes_orders
from hexwar_sb3.bots.missions import attack, give_mission
from hexwar_sb3.bots.points import choose_people, first_points, move_idle
from hexwar_sb3.bots.records import BANDS, AtlasRecord, BrainRecord
from hexwar_sb3.bots.registry import Pilot
from hexwar_sb3.bots.scout import air_prey
from hexwar_sb3.bots.weigh import known_lead, renew_trust, threat_at
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces, Rounds
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, SlotIndex, piece_range, slot_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import Missions, TaskKind

FAR_BAND = BANDS - 1  # of the atlas's posts: where those wait who set out later


@kernel
def think_drawn(
    camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """One thought of a member of "drawn"."""
    config, drawn = atlas.config, brain.drawn
    renew_trust(camp, game, memory, brain, config)
    share_points(camp, game, pieces, brain, atlas)
    leads = known_lead(camp, game, pieces, memory, rules) >= 0
    brain.rush = game.tick >= drawn.rush and (drawn.reckless == 1 or not leads)
    choose_people(drawn.style, camp, game, pieces, brain, rules, cells, eta, config)
    if drawn.stubborn == 0:
        move_idle(camp, game, pieces, memory, brain, cells, config, atlas)
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if not takes_orders(pieces[i], game):
            continue
        if not has_own_way(i, camp, game, pieces, memory, missions, brain, rules, cells, los, eta, atlas):
            order_duty(
                drawn.style, i, camp, game, pieces, memory, rounds, missions, brain, rules, cells, los, eta, atlas
            )  # fmt: skip


@kernel
def share_points(
    camp: CampIndex, game: GameRecord, pieces: Pieces, brain: BrainRecord, atlas: AtlasRecord
) -> None:
    """Say at the first thought, and where a feint ends, for which point each piece works."""
    drawn = brain.drawn
    if brain.thoughts == 1:
        first_points(camp, game, pieces, brain, atlas)
    for slot in slot_range(end_piece(camp, game) - first_piece(camp, game)):
        s = int(drawn.squad[slot])
        feints = game.tick < drawn.turn[s]
        turns = brain.stage[s] == 0 and not feints  # the squad's own point from now on
        if feints and brain.thoughts == 1:
            brain.point[slot] = atlas.rank[drawn.feint[s]]
        elif turns and (drawn.dealt == 0 or brain.thoughts > 1):
            brain.point[slot] = atlas.rank[drawn.point[s]]
    for s in range(drawn.turn.size):
        if game.tick >= drawn.turn[s]:
            brain.stage[s] = 1


@kernel
def has_own_way(
    i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> bool:  # fmt: skip
    """Let a piece wait, withdraw or hunt as it was drawn; False: it has its duty."""
    piece, drawn, slot = pieces[i], brain.drawn, SlotIndex(i - first_piece(camp, game))
    s = int(drawn.squad[slot])
    if piece.kind == PieceType.AEROCRAFT:
        return flies_own_way(i, camp, game, pieces, memory, missions, brain, rules, cells, atlas)
    if game.tick < drawn.start[s] and brain.rush == 0:
        cell = CellIndex(piece.cell)
        if drawn.staged == 1:
            post = CellIndex(atlas.post[camp, brain.point[slot], FAR_BAND, slot % atlas.post.shape[3]])
            cell = post if post != NO_CELL else cell
        brain.post[slot] = NO_CELL
        give_mission(drawn.style, i, TaskKind.HIDE, cell, game, missions)
        return True
    if piece.blood <= drawn.retreat_blood and brain.rush == 0 and brain.n_foes > 0:
        harm = threat_at(piece.kind, piece.cell, camp, pieces, memory, brain, rules, cells, los, atlas)
        if harm >= drawn.retreat_threat:
            brain.post[slot] = NO_CELL
            give_mission(drawn.style, i, TaskKind.HIDE, CellIndex(atlas.home[camp]), game, missions)
            return True
    if (
        game.tick >= drawn.hunt[s]
        and piece.kind != PieceType.SOLDIER
        and brain.keeper[brain.point[slot]] != slot
    ):
        prey = best_prey(i, camp, pieces, memory, brain, rules, cells, eta, atlas)
        if prey != NO_PIECE:
            brain.post[slot] = NO_CELL
            attack(drawn.style, i, TaskKind.ATTACK, prey, game, missions)
            return True
    return False


@kernel
def flies_own_way(
    i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord, rules: RulesRecord, cells: Cells,
    atlas: AtlasRecord,
) -> bool:  # fmt: skip
    """Let the aerocraft attack, or stay above its point; False: it scouts."""
    drawn = brain.drawn
    if drawn.pilot == Pilot.HUNTER:
        prey = air_prey(i, camp, game, pieces, memory, brain, rules, cells, atlas)
        if prey != NO_PIECE:
            attack(drawn.style, i, TaskKind.ATTACK, prey, game, missions)
            return True
    elif drawn.pilot == Pilot.PICKET and game.n_points > 0:
        point = CellIndex(game.point_cell[brain.point[SlotIndex(i - first_piece(camp, game))]])
        give_mission(drawn.style, i, TaskKind.HOLD, point, game, missions)
        return True
    return False
