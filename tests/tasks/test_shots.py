"""What a shot is worth, against sums over all dice and over all orders (bots.md, section 1)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.fire import attack_level, shot_mods
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.records import MAX_PIECES, NO_PIECE
from hexwar_sb3.rules import adjudicate
from hexwar_sb3.rules.enums import Action, PieceType, TargetClass, Weapon
from hexwar_sb3.rules.indices import PieceIndex, piece_range
from hexwar_sb3.tasks.shots import (
    KILL_BONUS,
    OBJECTIVE_FACTOR,
    best_guided,
    best_shot,
    expect_loss,
    expected_value,
    median_loss,
    shot_value,
    slot_bit,
)

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

N = 7
NOTHING = np.zeros(MAX_PIECES, np.int64)
DICE = range(1, 7)
CLASS = (TargetClass.VEHICLE, TargetClass.VEHICLE, TargetClass.SOLDIER, TargetClass.AEROCRAFT)


def results(board: Board, weapon: Weapon, blood: int, level: int, mods: int, kind: PieceType) -> list[int]:
    """Result of every throw of the dice, each as likely as any other."""
    armour = int(board.rules.armour[kind])
    two = [a + b for a, b in product(DICE, DICE)]
    second = [1] if kind == PieceType.AEROCRAFT else DICE if kind == PieceType.SOLDIER else two
    small = weapon == Weapon.SMALL and kind != PieceType.SOLDIER
    return [
        adjudicate(CLASS[kind], level, blood, armour, one, other, mods, small_arms=small)
        for one, other in product(two, second)
    ]


CASES = [
    (Weapon.GUN, 3, 9, 0, PieceType.TANK, 3),
    (Weapon.GUN, 1, 4, -4, PieceType.CHARIOT, 2),
    (Weapon.HEAVY, 2, 8, -3, PieceType.TANK, 1),
    (Weapon.CANNON, 3, 8, 2, PieceType.SOLDIER, 3),
    (Weapon.SMALL, 3, 6, -2, PieceType.CHARIOT, 3),
    (Weapon.PORT, 3, 8, 0, PieceType.AEROCRAFT, 1),
]


@pytest.mark.parametrize(("weapon", "blood", "level", "mods", "kind", "target_blood"), CASES)
def test_expected_value_is_the_sum_over_all_dice(
    board: Board, weapon: Weapon, blood: int, level: int, mods: int, kind: PieceType, target_blood: int
) -> None:
    """Losses capped at the blood; suppression counts 1/2 of a unit's value for soldiers, else 1/4."""
    light = 0.5 if kind == PieceType.SOLDIER else 0.25
    thrown = results(board, weapon, blood, level, mods, kind)
    units = [light if n == 0 else max(0, min(n, target_blood)) for n in thrown]
    kill = np.mean([n >= target_blood for n in thrown])
    value = int(board.rules.value[kind])

    plain = expected_value(weapon, blood, level, mods, kind, target_blood, False, board.rules)
    full = expected_value(weapon, blood, level, mods, kind, target_blood, True, board.rules)

    assert plain == pytest.approx(value * np.mean(units), rel=1e-5)
    assert full - plain == pytest.approx(value * KILL_BONUS * kill, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(("weapon", "blood", "level", "mods", "kind", "target_blood"), CASES)
def test_median_loss_is_the_most_that_half_of_all_throws_reach(
    board: Board, weapon: Weapon, blood: int, level: int, mods: int, kind: PieceType, target_blood: int
) -> None:
    losses = np.clip(results(board, weapon, blood, level, mods, kind), 0, target_blood)
    expected = max(n for n in range(target_blood + 1) if np.mean(losses >= n) >= 0.5)

    assert median_loss(weapon, blood, level, mods, kind, target_blood, board.rules) == expected


def test_values_read_only_what_the_camp_remembers(field: Board) -> None:
    """An enemy's real blood and cover do not count where it was last seen otherwise."""
    place(field)
    j = field.i("blue:chariot0")
    before = value_of(field, "tank0", j, Weapon.GUN)
    field.pieces[j].blood, field.pieces[j].hidden = 1, 1
    assert value_of(field, "tank0", j, Weapon.GUN) == before
    field.memory[0, j].blood = 1
    assert value_of(field, "tank0", j, Weapon.GUN) != before


def place(field: Board) -> None:
    """A red tank and a blue chariot five cells apart, far from everybody else."""
    field.put("tank0", field.cell(20, 2))
    field.put("blue:chariot0", field.cell(25, 2))
    field.look()


def value_of(board: Board, name: str, j: PieceIndex, weapon: Weapon) -> float:
    return shot_value(
        board.i(name),
        j,
        weapon,
        False,
        NOTHING,
        board.game,
        board.pieces,
        board.memory,
        board.rules,
        board.cells,
    )


def test_a_shot_of_a_seen_target_is_valued_with_the_engines_level_and_modifiers(
    middle: Callable[[int], Board],
) -> None:
    """What is seen is known exactly, so the engine's own level and modifiers must come out."""
    compared = 0
    for seed in range(8):
        board = middle(seed)
        for i, j, weapon in product(piece_range(N), piece_range(N, 2 * N), Weapon):
            me, target = board.pieces[i], board.pieces[j]
            if (
                not (int(me.sees) >> int(board.pieces[j].slot)) & 1
                or me.blood == 0
                or board.rules.pool[me.kind, weapon] < 0
            ):
                continue
            level = attack_level(weapon, me, target, board.rules, board.cells)
            mods = shot_mods(me, target, board.pieces, board.rules, board.cells)
            value = shot_value(
                i, j, weapon, False, NOTHING, board.game, board.pieces, board.memory, board.rules, board.cells
            )
            expected = 0.0
            if level > 0:
                expected = expected_value(
                    weapon, me.blood, level, mods, target.kind, target.blood, True, board.rules
                )
            assert value == pytest.approx(expected) or value == pytest.approx(expected * OBJECTIVE_FACTOR)
            compared += 1
    assert compared > 0


def test_a_target_beside_a_point_of_others_counts_half_as_much_again(field: Board) -> None:
    place(field)
    j = field.i("blue:chariot0")
    plain = value_of(field, "tank0", j, Weapon.GUN)
    field.game.point_cell[0] = field.cells[field.pieces[j].cell].neighbour[0]

    assert value_of(field, "tank0", j, Weapon.GUN) == pytest.approx(OBJECTIVE_FACTOR * plain)
    field.game.point_owner[0] = 0
    assert value_of(field, "tank0", j, Weapon.GUN) == plain


def legal_shots(board: Board, i: PieceIndex) -> list[tuple[float, PieceIndex, int]]:
    """Value, target, weapon of every shot that the engine would accept now."""
    order, shots = board.orders[i].copy(), []
    for j, weapon in product(piece_range(N, 2 * N), Weapon):
        order.kind, order.target, order.weapon = Action.SHOOT, j, weapon
        if order_code(i, order, board.game, board.pieces, board.rules, board.cells) == Code.OK:
            value = shot_value(
                i, j, weapon, False, NOTHING, board.game, board.pieces, board.memory, board.rules, board.cells
            )
            shots.append((value, j, int(weapon)))
    return shots


def test_best_shot_is_the_best_of_all_legal_shots(middle: Callable[[int], Board]) -> None:
    found = 0
    for seed in range(16):
        board = middle(seed)
        for i in piece_range(N):
            shots = legal_shots(board, i)
            value, j, weapon = best_shot(
                i, NO_PIECE, False, NOTHING, board.game, board.pieces, board.memory, board.rules, board.cells
            )
            assert value == max((shot[0] for shot in shots), default=0.0)
            assert (value, j, weapon) in shots or (value == 0.0 and j == NO_PIECE)
            found += value > 0.0
    assert found > 0


def test_best_shot_may_be_asked_for_one_target_only(field: Board) -> None:
    place(field)
    j, other = field.i("blue:chariot0"), field.i("blue:tank0")
    args = (field.game, field.pieces, field.memory, field.rules, field.cells)

    assert best_shot(field.i("tank0"), j, False, NOTHING, *args)[1] == j
    assert best_shot(field.i("tank0"), other, False, NOTHING, *args) == (0.0, NO_PIECE, -1)


def test_a_settled_view_leaves_motion_and_cool_down_aside(field: Board) -> None:
    place(field)
    tank = field.pieces[field.i("tank0")]
    args = (NOTHING, field.game, field.pieces, field.memory, field.rules, field.cells)
    standing = best_shot(field.i("tank0"), NO_PIECE, False, *args)
    tank.cool_ends, tank.stop_ends = 40, 50

    assert best_shot(field.i("tank0"), NO_PIECE, False, *args)[0] == 0.0
    assert best_shot(field.i("tank0"), NO_PIECE, True, *args) == standing


def test_allotted_losses_lower_the_value_for_the_next_shooter(field: Board) -> None:
    place(field)
    i, j = field.i("tank0"), field.i("blue:chariot0")
    args = (field.game, field.pieces, field.memory, field.rules, field.cells)
    allotted = NOTHING.copy()
    first = best_shot(i, NO_PIECE, False, allotted, *args)
    expect_loss(i, j, first[2], allotted, *args)

    assert allotted[j] >= 1
    assert best_shot(i, NO_PIECE, False, allotted, *args)[0] < first[0]


def test_best_guided_finds_the_pair_that_the_engine_accepts(field: Board) -> None:
    """Section 8: the guider sees the vehicle, the chariot need not."""
    place(field)
    field.land("soldier0")
    field.put("soldier0", field.cell(18, 2))
    field.put("chariot0", field.cell(12, 2))
    field.put("chariot1", field.cell(12, 2))
    field.look()
    args = (NOTHING, field.game, field.pieces, field.memory, field.orders, field.rules, field.cells)
    i, j, c = field.i("soldier0"), field.i("blue:chariot0"), field.i("chariot0")

    value, target, chariot = best_guided(i, NO_PIECE, np.uint64(0), *args)

    assert (target, chariot) == (j, c)
    order = field.orders[i]
    order.kind, order.target, order.partner = Action.GUIDE_SHOOT, target, chariot
    assert order_code(i, order, field.game, field.pieces, field.rules, field.cells) == Code.OK
    assert value == pytest.approx(value_of(field, "chariot0", j, Weapon.HEAVY))
    assert best_guided(i, NO_PIECE, slot_bit(field.pieces[c]), *args)[0] == 0.0
    field.orders[c].kind = Action.HIDE
    assert best_guided(i, NO_PIECE, np.uint64(0), *args)[0] == 0.0
