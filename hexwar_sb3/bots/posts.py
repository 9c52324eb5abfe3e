"""Where a piece fires from: the best post for what it knows (bots.md, sections 1 and 2.5)."""

from __future__ import annotations

from hexwar_sb3.bots.atlas import cell_at
from hexwar_sb3.bots.config import Style
from hexwar_sb3.bots.records import BANDS, POSTS, RING, AtlasRecord, BrainRecord
from hexwar_sb3.bots.weigh import (
    danger_of,
    danger_row,
    exposed_reach,
    gain_at,
    guided_gain,
    threat_at,
)
from hexwar_sb3.engine.pieces import stands_in
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.maps.sightlines import line_of_sight
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, PointIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks

WORST = -1e9


@kernel
def choose_post(
    style: Style, i: PieceIndex, prey: PieceIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> CellIndex:  # fmt: skip
    """The best post of piece i: the one it has unless another is clearly better.

    Args:
        prey: a known enemy, around which posts are looked for too, or NO_PIECE.
    """
    slot = SlotIndex(i - first_piece(camp, game))
    k = brain.point[slot]
    best = CellIndex(brain.post[slot])
    bonus = style.move_gain
    if best == NO_CELL:
        best, bonus = CellIndex(pieces[i].cell), 0.0
    best_score = bonus + post_score(
        style, i, best, k, WORST, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
    )
    around = memory[camp, prey].cell if prey != NO_PIECE else NO_CELL
    for n in range(list_posts(CellIndex(pieces[i].cell), around, k, camp, brain, cells, atlas)):
        cell = CellIndex(brain.choices[n])
        score = post_score(
            style, i, cell, k, best_score, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
        )  # fmt: skip
        if score > best_score:
            best, best_score = cell, score
    return best


@kernel
def list_posts(
    here: CellIndex,
    around: CellIndex,
    k: PointIndex,
    camp: CampIndex,
    brain: BrainRecord,
    cells: Cells,
    atlas: AtlasRecord,
) -> int:
    """Fill `brain.choices` with cells worth a look, in the camp's order; returns their number.

    The atlas's posts of the point; with known enemies also the cells beside `here`; those in rings
    about `around` where that is a cell.
    """
    count = 0
    for band in range(BANDS):
        for n in range(POSTS):
            count = note_cell(CellIndex(atlas.post[camp, k, band, n]), count, brain, cells)
    if brain.n_foes > 0:
        for n in range(atlas.config.near_posts):
            cell = cell_at(here, atlas.around[n, 0], atlas.around[n, 1], camp, cells, atlas)
            count = note_cell(cell, count, brain, cells)
    if around != NO_CELL:
        for n in range(RING):
            cell = cell_at(around, atlas.ring[n, 0], atlas.ring[n, 1], camp, cells, atlas)
            count = note_cell(cell, count, brain, cells)
    return count


@kernel
def note_cell(cell: CellIndex, count: int, brain: BrainRecord, cells: Cells) -> int:
    """Add a cell to the choices if ground pieces may stand there; returns the new count."""
    if cell == NO_CELL or cells[cell].passable == 0:
        return count
    brain.choices[count] = cell
    return count + 1


@kernel
def post_score(
    style: Style, i: PieceIndex, cell: CellIndex, k: PointIndex, at_least: float, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory,
    brain: BrainRecord, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> float:  # fmt: skip
    """Worth of a cell as the post of piece i, points; WORST where it cannot stand.

    Args:
        k: the control point that the piece works for.
        at_least: a lower score is of no interest, and need not be exact.
    """
    piece = pieces[i]
    row = danger_row(piece, rules)
    most_gain = atlas.best_gain[piece.kind]
    lasting = lasting_worth(style, piece.kind, row, cell, game.point_cell[k], rules, cells, los, atlas)
    least_ticks = int(rules.base_hop[piece.kind]) * cells_apart(cells, piece.cell, cell)
    if at_most(style, lasting, least_ticks, most_gain) <= at_least:
        return WORST  # without a look at the way, which mostly lies far off in memory
    ticks = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
    if at_most(style, lasting, ticks, most_gain) <= at_least:
        return WORST
    score = lasting - ticks / style.eta_ticks
    sure = 1.0 / (1.0 + ticks / style.patience_ticks)
    if ticks >= UNREACHABLE or is_taken(i, cell, camp, game, pieces, brain):
        return WORST
    if brain.n_foes == 0:
        return score
    gain = gain_at(piece.kind, row, cell, camp, pieces, memory, brain, rules, cells, los, atlas)
    if piece.kind == PieceType.CHARIOT:
        gain = max(gain, guided_gain(i, row, cell, camp, game, pieces, memory, brain, cells, atlas))
    if score + sure * style.gain_weight * gain <= at_least:
        return WORST
    threat = threat_at(piece.kind, cell, camp, pieces, memory, brain, rules, cells, los, atlas)
    return score + sure * (style.gain_weight * gain - style.threat_weight * threat)


@kernel
def at_most(style: Style, lasting: float, ticks: int, most_gain: float) -> float:
    """The most that a cell so far away can be worth, points."""
    return (
        lasting
        - ticks / style.eta_ticks
        + 1.0 / (1.0 + ticks / style.patience_ticks) * style.gain_weight * most_gain
    )


@kernel
def lasting_worth(
    style: Style, kind: int, row: int, cell: CellIndex, point: CellIndex, rules: RulesRecord, cells: Cells, los: Sightlines, atlas: AtlasRecord
) -> float:  # fmt: skip
    """What a cell is worth whoever is known: cover, and a duel with a tank that stands on the point."""
    worth = style.cover_weight * cells[cell].concealed
    if not line_of_sight(los, 0, point, cell, cells):  # from one window for all cells that are looked at
        return worth
    worth += style.reach_weight * danger_of(row, cell, PieceType.TANK, point, 0, cells, atlas)
    if cells_apart(cells, cell, point) <= exposed_reach(PieceType.TANK, kind, cell, rules, cells):
        shelter = int(cells[cell].concealed)
        worth -= style.risk_weight * danger_of(PieceType.TANK, point, kind, cell, shelter, cells, atlas)
    return worth


@kernel
def is_taken(
    i: PieceIndex, cell: CellIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, brain: BrainRecord
) -> bool:
    """Another own ground piece stands there or is on its way there: two in a cell are a better target."""
    first = first_piece(camp, game)
    for other in piece_range(first, end_piece(camp, game)):
        if other == i or pieces[other].blood == 0 or pieces[other].carrier != NO_PIECE:
            continue
        if stands_in(pieces[other], cell) or brain.post[SlotIndex(other - first)] == cell:
            return True
    return False
