"""Where a piece fires from: the best post for what it knows (bots.md, sections 2.5 and 3.1)."""

from __future__ import annotations

from hexwar_sb3.bots.atlas import cell_at
from hexwar_sb3.bots.weigh import gain_at, threat_at
from hexwar_sb3.engine.pieces import stands_in
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks

WORST = -1e9


@kernel
def post_score(
    style: Row, i: int, cell: int, worth: float, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> float:  # fmt: skip
    """Worth of a cell as the post of piece i, points; WORST where it cannot stand."""
    piece = pieces[i]
    ticks = travel_ticks(piece.kind, piece.cell, cell, rules, cells, eta)
    if ticks >= UNREACHABLE or is_taken(i, cell, camp, game, pieces, brain):
        return WORST
    gain = gain_at(piece.kind, cell, camp, game, pieces, memory, brain, rules, cells, los, atlas)
    threat = threat_at(piece.kind, cell, camp, game, pieces, memory, brain, rules, cells, los, atlas)
    score = style.gain_weight * gain - style.threat_weight * threat + worth
    return score - ticks / style.eta_ticks


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
    style: Row, i: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> int:  # fmt: skip
    """The best post of piece i: its present one unless another is clearly better."""
    slot = i - first_piece(camp, game)
    k = brain.point[slot]
    present = int(brain.post[slot])
    best, best_score = int(pieces[i].cell), 0.0
    best_score = post_score(
        style, i, best, lasting_worth(style, best, k, camp, atlas), camp, game, pieces, memory, brain,
        rules, cells, los, eta, atlas,
    )  # fmt: skip
    if present == best:
        best_score += style.move_gain
    elif present != NO_CELL:
        score = post_score(
            style, i, present, lasting_worth(style, present, k, camp, atlas), camp, game, pieces, memory, brain,
            rules, cells, los, eta, atlas,
        )  # fmt: skip
        if score + style.move_gain > best_score:
            best, best_score = present, score + style.move_gain
    for band in range(atlas.post.shape[2]):
        for n in range(atlas.post.shape[3]):
            cell = int(atlas.post[camp, k, band, n])
            if cell == NO_CELL:
                break
            worth = style.post_weight * atlas.post_worth[camp, k, band, n] + style.band_worth[band]
            score = post_score(
                style, i, cell, worth, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
            )
            if score > best_score:
                best, best_score = cell, score
    return best


@kernel
def lasting_worth(style: Row, cell: int, k: int, camp: int, atlas: Row) -> float:
    """What the atlas says of a cell as a post of point k; 0: not among the best."""
    for band in range(atlas.post.shape[2]):
        for n in range(atlas.post.shape[3]):
            if atlas.post[camp, k, band, n] == cell:
                return float(style.post_weight * atlas.post_worth[camp, k, band, n] + style.band_worth[band])
    return 0.0


@kernel
def hunting_post(
    style: Row, i: int, prey: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> int:  # fmt: skip
    """The best cell around a known enemy, or here."""
    best = int(pieces[i].cell)
    best_score = style.move_gain + post_score(
        style, i, best, 0.0, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
    )
    for n in range(atlas.ring.shape[0]):
        cell = cell_at(memory[camp, prey].cell, atlas.ring[n, 0], atlas.ring[n, 1], camp, cells, atlas)
        if cell == NO_CELL or cells[cell].passable == 0:
            continue
        score = post_score(
            style, i, cell, 0.0, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas
        )
        if score > best_score:
            best, best_score = cell, score
    return best
