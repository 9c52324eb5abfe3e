"""Where the aerocraft flies: to what it can shoot or guide at, out of the way of what shoots it down."""

from __future__ import annotations

from hexwar_sb3.bots.atlas import cell_at
from hexwar_sb3.bots.config import Style
from hexwar_sb3.bots.records import AtlasRecord, BrainRecord
from hexwar_sb3.bots.weigh import gain_at, threat_at
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece


@kernel
def scout(
    style: Style, i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, atlas: AtlasRecord,
) -> CellIndex:  # fmt: skip
    """Cell for the aerocraft: around its prey if there is one, else above the point that it works for."""
    prey = air_prey(i, camp, game, pieces, memory, brain, rules, cells, atlas)
    around = CellIndex(memory[camp, prey].cell) if prey != NO_PIECE else picket(i, camp, game, pieces, brain)
    kind = PieceType.AEROCRAFT
    best, best_score = CellIndex(pieces[i].cell), -1e9
    for n in range(atlas.around.shape[0]):
        cell = cell_at(around, atlas.around[n, 0], atlas.around[n, 1], camp, cells, atlas)
        if cell == NO_CELL:
            continue
        far = cells_apart(cells, cell, pieces[i].cell) * atlas.config.flight_cost
        if prey == NO_PIECE:
            far += cells_apart(cells, cell, around)
        if style.gain_weight * atlas.best_gain[kind] - far <= best_score:
            continue
        gain = gain_at(kind, kind, cell, camp, pieces, memory, brain, rules, cells, los, atlas)
        score = style.gain_weight * gain - far
        if score <= best_score:
            continue
        threat = threat_at(kind, cell, camp, pieces, memory, brain, rules, cells, los, atlas)
        score -= style.threat_weight * threat
        if score > best_score:
            best, best_score = cell, score
    return best


@kernel
def air_prey(
    i: PieceIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    brain: BrainRecord,
    rules: RulesRecord,
    cells: Cells,
    atlas: AtlasRecord,
) -> PieceIndex:
    """Known enemy vehicle that is worth most for the way to it; NO_PIECE."""
    best, prey = 0.0, NO_PIECE
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        kind = pieces[j].kind
        if brain.trust[j] <= 0.0 or kind == PieceType.AEROCRAFT or kind == PieceType.SOLDIER:
            continue
        ticks = rules.base_hop[PieceType.AEROCRAFT] * cells_apart(cells, pieces[i].cell, memory[camp, j].cell)
        value = brain.trust[j] * rules.value[kind] / (1.0 + ticks / atlas.config.hunt_ticks)
        if value > best:
            best, prey = value, j
    return prey


@kernel
def picket(i: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, brain: BrainRecord) -> CellIndex:
    """Where the aerocraft waits for prey: above the point that it works for."""
    k = brain.point[SlotIndex(i - first_piece(camp, game))]
    if game.n_points == 0:
        return CellIndex(pieces[i].cell)
    return CellIndex(game.point_cell[k])
