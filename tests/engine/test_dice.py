"""Dice (rule book, section 11)."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from hexwar_sb3.engine.dice import die, priority, splitmix64, two_dice
from hexwar_sb3.engine.state import new_state, reset_game
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.enums import Dice


@pytest.fixture
def table(small_world: World) -> tuple[Row, Rows]:
    state = new_state(small_world, 1)
    reset_game(state, 0, small_world, 12)
    return state.games[0], state.pieces[0]


@pytest.mark.parametrize(("x", "expected"), [(0, 0xE220A8397B1DCDAF), (1234567, 0x599ED017FB08FC85)])
def test_splitmix64_is_the_published_generator(x: int, expected: int) -> None:
    """First outputs of the reference implementation for the seeds 0 and 1234567."""
    assert int(splitmix64(np.uint64(x))) == expected


def test_a_die_has_six_equal_faces(table: tuple[Row, Rows]) -> None:
    """Section 11: die = 1 + floor(u_high32 x 6 / 2^32)."""
    game, pieces = table
    faces = Counter(die(game, t, Dice.DIRECT, pieces[0], pieces[8], n) for t in range(1500) for n in range(4))
    assert set(faces) == {1, 2, 3, 4, 5, 6}
    assert all(abs(count - 1000) < 4 * (6000 * 5 / 36) ** 0.5 for count in faces.values())


def test_two_dice_are_two_dice(table: tuple[Row, Rows]) -> None:
    game, pieces = table
    for t in range(50):
        one = die(game, t, Dice.AIR, pieces[1], pieces[9], 0)
        other = die(game, t, Dice.AIR, pieces[1], pieces[9], 1)
        assert two_dice(game, t, Dice.AIR, pieces[1], pieces[9], 0) == one + other


def test_every_purpose_has_dice_of_its_own(table: tuple[Row, Rows]) -> None:
    """Section 11: keyed by step, kind, shooter, target, draw and seed."""
    game, pieces = table

    def row(tick: int = 3, kind: int = Dice.DIRECT, a: int = 0, b: int = 8, draw: int = 0) -> list[int]:
        return [die(game, tick + 100 * k, kind, pieces[a], pieces[b], draw) for k in range(30)]

    base = row()
    others = [row(tick=4), row(kind=Dice.DIRECT_CORRECTION), row(a=1), row(b=9), row(a=8, b=0), row(draw=1)]
    game.seed += np.uint64(1)
    others.append(row())
    assert base not in others
    assert len({tuple(other) for other in others}) == len(others)


def test_the_camps_do_not_share_dice(table: tuple[Row, Rows]) -> None:
    """Section 11: ids are hashed with the salt of the camp; exchanged salts exchange the dice."""
    game, pieces = table
    red = [die(game, t, Dice.DIRECT, pieces[0], pieces[8], 0) for t in range(40)]
    blue = [die(game, t, Dice.DIRECT, pieces[7], pieces[1], 0) for t in range(40)]
    assert red != blue
    game.salt[:] = game.salt[::-1].copy()
    assert [die(game, t, Dice.DIRECT, pieces[7], pieces[1], 0) for t in range(40)] == red


def test_priority_orders_the_pieces_of_a_camp_anew_in_every_step(table: tuple[Row, Rows]) -> None:
    """Section 11: prio(t, id)."""
    game, pieces = table
    first = Counter(min(range(7), key=lambda i: int(priority(game, t, pieces[i]))) for t in range(700))
    assert all(50 < first[i] < 160 for i in range(7))
