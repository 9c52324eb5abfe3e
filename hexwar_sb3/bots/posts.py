"""Where a piece fires from: the best post for what it knows (bots.md, sections 1 and 2.5)."""

from __future__ import annotations

from hexwar_sb3.bots.atlas import cell_at
from hexwar_sb3.bots.weigh import danger_row, gain_at, guided_gain, threat_at
from hexwar_sb3.engine.pieces import stands_in
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks

WORST = -1e9


@kernel
def post_score(
    style: Row, i: int, cell: int, worth: float, at_least: float, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> float:  # fmt: skip
    """Worth of a cell as the post of piece i, points; WORST where it cannot stand.

    Args:
        worth: what the cell is worth whatever the enemy does.
        at_least: a lower score is of no interest, and need not be exact.
    """
    piece = pieces[i]
    ticks = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
    score = worth - ticks / style.eta_ticks
    if score + style.gain_weight * atlas.best_gain[piece.kind] <= at_least:
        return WORST
    if ticks >= UNREACHABLE or is_taken(i, cell, camp, game, pieces, brain):
        return WORST
    if brain.n_foes == 0:
        return score
    row = danger_row(piece, rules)
    gain = gain_at(piece.kind, row, cell, camp, game, pieces, memory, brain, rules, cells, los, atlas)
    if piece.kind == PieceType.CHARIOT:
        gain = max(gain, guided_gain(i, row, cell, camp, game, pieces, memory, brain, rules, cells, atlas))
    threat = threat_at(piece.kind, cell, camp, game, pieces, memory, brain, rules, cells, los, atlas)
    lasting = 1.0 / (1.0 + ticks / style.patience_ticks)
    return score + lasting * (style.gain_weight * gain - style.threat_weight * threat)


@kernel
def is_taken(i: int, cell: int, camp: int, game: Row, pieces: Rows, brain: Row) -> bool:
    """Another own ground piece stands there or is on its way there: two in a cell are a better target."""
    first = first_piece(camp, game)
    for other in range(first, end_piece(camp, game)):
        if other == i or pieces[other].blood == 0 or pieces[other].carrier != NO_PIECE:
            continue
        if stands_in(pieces[other], cell) or brain.post[other - first] == cell:
            return True
    return False


@kernel
def choose_post(
    style: Row, i: int, prey: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> int:  # fmt: skip
    """The best post of piece i: the one it has unless another is clearly better.

    Args:
        prey: a known enemy, around which posts are looked for too, or NO_PIECE.
    """
    here = int(pieces[i].cell)
    k = brain.point[i - first_piece(camp, game)]
    present = int(brain.post[i - first_piece(camp, game)])
    best = present if present != NO_CELL else here
    best_score = post_score(
        style, i, best, lasting_worth(style, pieces[i].kind, best, k, camp, cells, atlas), WORST, camp, game, pieces, memory, brain,
        rules, cells, los, eta, atlas,
    )  # fmt: skip
    if present != NO_CELL:
        best_score += style.move_gain
    for band in range(atlas.post.shape[2]):
        for n in range(atlas.post.shape[3]):
            cell = int(atlas.post[camp, k, band, n])
            if cell == NO_CELL:
                break
            worth = style.post_weight * atlas.post_worth[camp, k, band, n] + band_worth(
                style, pieces[i].kind, band
            )
            score = post_score(
                style,
                i,
                cell,
                worth,
                best_score,
                camp,
                game,
                pieces,
                memory,
                brain,
                rules,
                cells,
                los,
                eta,
                atlas,
            )
            if score > best_score:
                best, best_score = cell, score
    if brain.n_foes > 0:
        for n in range(atlas.config.near_posts):
            cell = cell_at(here, atlas.around[n, 0], atlas.around[n, 1], camp, cells, atlas)
            if cell == NO_CELL or cells[cell].passable == 0:
                continue
            score = post_score(
                style,
                i,
                cell,
                atlas.config.elsewhere_worth,
                best_score,
                camp,
                game,
                pieces,
                memory,
                brain,
                rules,
                cells,
                los,
                eta,
                atlas,
            )
            if score > best_score:
                best, best_score = cell, score
    if prey != NO_PIECE:
        for n in range(atlas.ring.shape[0]):
            cell = cell_at(memory[camp, prey].cell, atlas.ring[n, 0], atlas.ring[n, 1], camp, cells, atlas)
            if cell == NO_CELL or cells[cell].passable == 0:
                continue
            score = post_score(
                style,
                i,
                cell,
                atlas.config.elsewhere_worth,
                best_score,
                camp,
                game,
                pieces,
                memory,
                brain,
                rules,
                cells,
                los,
                eta,
                atlas,
            )
            if score > best_score:
                best, best_score = cell, score
    return best


@kernel
def lasting_worth(style: Row, kind: int, cell: int, k: int, camp: int, cells: Rows, atlas: Row) -> float:
    """What the atlas says of a cell as a post of point k; or of any other cell."""
    for band in range(atlas.post.shape[2]):
        for n in range(atlas.post.shape[3]):
            if atlas.post[camp, k, band, n] == cell:
                worth = style.post_weight * atlas.post_worth[camp, k, band, n]
                return float(worth + band_worth(style, kind, band))
    return elsewhere(cell, cells, atlas.config)


@kernel
def band_worth(style: Row, kind: int, band: int) -> float:
    """What a type of piece adds to posts of a band of distances: chariots keep farther off than tanks."""
    if kind == PieceType.CHARIOT:
        return float(style.chariot_worth[band])
    return float(style.band_worth[band])


@kernel
def elsewhere(cell: int, cells: Rows, config: Row) -> float:
    """Lasting worth of a cell that is no post of any point."""
    if cells[cell].concealed:
        return float(config.elsewhere_worth + config.shelter_worth)
    return float(config.elsewhere_worth)
