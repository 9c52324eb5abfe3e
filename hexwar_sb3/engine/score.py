"""Scores: eq. (1) of the paper and the net form (rule book, section 12)."""

from __future__ import annotations

from hexwar_sb3.engine.records import NO_CELL
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.rules.enums import Camp


@kernel
def points_value(game: Row, owner: int) -> int:
    """Value of the control points that a camp (GREEN too) owns."""
    total = 0
    for k in range(int(game.n_points)):
        if game.point_owner[k] == owner:
            total += game.point_value[k]
    return total


@kernel
def points_held(game: Row, camp: int) -> int:
    """Number of control points that a camp owns."""
    held = 0
    for k in range(int(game.n_points)):
        if game.point_owner[k] == camp:
            held += 1
    return held


@kernel
def own_total(game: Row, pieces: Rows, camp: int, rules: Row) -> int:
    """Value of a camp's pieces, passengers included, and of its control points."""
    total = points_value(game, camp)
    for i in range(pieces.size):
        if pieces[i].camp == camp:
            total += rules.value[pieces[i].kind] * pieces[i].blood
    return total


@kernel
def margin(game: Row, pieces: Rows, camp: int, rules: Row) -> int:
    """v_c of eq. (1): own total minus everybody else's, neutral points included unless `net_score`."""
    total = own_total(game, pieces, camp, rules) - own_total(game, pieces, 1 - camp, rules)
    if game.net_score:
        return total
    return total - points_value(game, Camp.GREEN)


@kernel
def known_margin(game: Row, pieces: Rows, memory: Rows, camp: int, rules: Row) -> int:
    """The margin as the camp knows it: enemies at their last seen blood, never seen ones at full blood."""
    total = own_total(game, pieces, camp, rules) - points_value(game, 1 - camp)
    if not game.net_score:
        total -= points_value(game, Camp.GREEN)
    for j in range(pieces.size):
        if pieces[j].camp != camp:
            known = memory[camp, j]
            blood = known.blood if known.cell != NO_CELL else rules.blood[pieces[j].kind]
            total -= rules.value[pieces[j].kind] * blood
    return total
