"""Scores: eq. (1) of the paper and the net form (rule book, section 12)."""

from __future__ import annotations

from hexwar_sb3.engine.records import NO_CELL, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CampIndex, piece_range, point_range


@kernel
def points_value(game: GameRecord, owner: CampIndex) -> int:
    """Value of the control points that a camp (GREEN too) owns."""
    total = 0
    for k in point_range(game.n_points):
        if game.point_owner[k] == owner:
            total += game.point_value[k]
    return total


@kernel
def points_held(game: GameRecord, camp: CampIndex) -> int:
    """Number of control points that a camp owns."""
    held = 0
    for k in point_range(game.n_points):
        if game.point_owner[k] == camp:
            held += 1
    return held


@kernel
def own_total(game: GameRecord, pieces: Pieces, camp: CampIndex, rules: RulesRecord) -> int:
    """Value of a camp's pieces, passengers included, and of its control points."""
    total = points_value(game, camp)
    for i in piece_range(pieces.size):
        if pieces[i].camp == camp:
            total += rules.value[pieces[i].kind] * pieces[i].blood
    return total


@kernel
def margin(game: GameRecord, pieces: Pieces, camp: CampIndex, rules: RulesRecord) -> int:
    """v_c of eq. (1): own total minus everybody else's, neutral points included unless `net_score`."""
    total = own_total(game, pieces, camp, rules) - own_total(game, pieces, CampIndex(1 - camp), rules)
    if game.net_score:
        return total
    return total - points_value(game, Camp.GREEN)


@kernel
def known_margin(
    game: GameRecord, pieces: Pieces, memory: Memory, camp: CampIndex, rules: RulesRecord
) -> int:
    """The margin as the camp knows it: enemies at their last seen blood, never seen ones at full blood."""
    total = own_total(game, pieces, camp, rules) - points_value(game, CampIndex(1 - camp))
    if not game.net_score:
        total -= points_value(game, Camp.GREEN)
    for j in piece_range(pieces.size):
        if pieces[j].camp != camp:
            known = memory[camp, j]
            blood = known.blood if known.cell != NO_CELL else rules.blood[pieces[j].kind]
            total -= rules.value[pieces[j].kind] * blood
    return total
