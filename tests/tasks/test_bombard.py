"""What a mortar round is worth, against the sum over all dice (rule book, section 9)."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hexwar_sb3.rules.compiled import SCATTER_HIT
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.bombard import landing_value, mortar_value

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

DICE = range(1, 7)
TWO = [a + b for a, b in product(DICE, DICE)]


def thrown_value(board: Board, kind: PieceType, blood: int, mods: int, correction_class: int) -> float:
    """Mean over every throw: scatter, result, correction."""
    rules, light = board.rules, 0.5 if kind == PieceType.SOLDIER else 0.25
    total = 0.0
    for scatter, roll, face in product(TWO, TWO, DICE):
        away = rules.scatter[correction_class, scatter, 0]
        if away not in (SCATTER_HIT, 0):
            continue
        raw = int(rules.burst_result[1 if away == SCATTER_HIT else 0, roll])
        corr = int(rules.burst_correction[np.clip(face + mods, 0, 8)])
        result = max(-1, raw + corr)
        units = light if result == 0 else max(0, min(result, blood)) + 0.5 * (result >= blood)
        total += units if raw >= 0 else 0.0
    return int(rules.value[kind]) * total / (36 * 36 * 6)


@pytest.mark.parametrize(
    ("kind", "blood", "mods"), [(PieceType.TANK, 3, -3), (PieceType.SOLDIER, 1, 1), (PieceType.CHARIOT, 2, 2)]
)
def test_landing_value_is_the_mean_over_all_dice(
    board: Board, kind: PieceType, blood: int, mods: int
) -> None:
    for observed, correction_class in ((True, 2), (False, 0)):
        expected = thrown_value(board, kind, blood, mods, correction_class)
        assert landing_value(kind, blood, mods, observed, board.rules) == pytest.approx(expected)


def test_own_pieces_under_the_round_count_against_it(field: Board) -> None:
    cell = field.cell(20, 2)
    field.put("chariot0", field.cell(10, 2))
    field.put("blue:soldier0", cell, carrier=-1)
    field.put("tank1", field.cell(16, 2))
    field.look()
    args = (field.game, field.pieces, field.memory, field.rules, field.cells)
    i = field.i("chariot0")

    alone = mortar_value(i, cell, True, *args)
    field.put("tank0", cell)

    assert alone > 0.0
    assert mortar_value(i, cell, True, *args) < alone
    assert mortar_value(i, field.cell(25, 2), True, *args) == 0.0
