"""The odds tables against every throw counted one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexwar_sb3.rules import RuleSet, adjudicate, default_rules

DIE = range(1, 7)
TWO_DICE = [first + second for first, second in product(DIE, DIE)]
RESULTS = range(-1, 6)

levels, bloods, armours = st.integers(1, 10), st.integers(1, 5), st.integers(0, 4)
modifiers = st.integers(-8, 2)
few = settings(max_examples=12, deadline=None, derandomize=True)

ODDS = default_rules().compiled()[0]


def counted(
    target: str, level: int, blood: int, armour: int, mods: int, *, small: bool = False
) -> list[float]:
    """Chances of results -1..5 (5: or more) by throwing every throw."""
    second = DIE if target == "soldier" else TWO_DICE
    throws = list(product(TWO_DICE, second))
    results = Counter(
        min(adjudicate(target, level, blood, armour, first, then, mods, small_arms=small), 5)
        for first, then in throws
    )
    return [results[result] / len(throws) for result in RESULTS]


@few
@given(levels, bloods, armours, modifiers)
def test_the_chances_against_a_vehicle_are_those_of_all_throws(
    level: int, blood: int, armour: int, mods: int
) -> None:
    chances = ODDS.odds_vehicle[armour, blood, level, mods + 8]

    np.testing.assert_allclose(chances, counted("vehicle", level, blood, armour, mods), atol=1e-6)


@few
@given(levels, armours, modifiers)
def test_the_chances_of_small_arms_against_a_vehicle_are_those_of_all_throws(
    level: int, armour: int, mods: int
) -> None:
    chances = ODDS.odds_small[armour, level, mods + 8]

    np.testing.assert_allclose(chances, counted("vehicle", level, 1, armour, mods, small=True), atol=1e-6)


@few
@given(levels, modifiers)
def test_the_chances_against_a_soldier_are_those_of_all_throws(level: int, mods: int) -> None:
    chances = ODDS.odds_soldier[level, mods + 8]

    np.testing.assert_allclose(chances, counted("soldier", level, 1, 0, mods), atol=1e-6)


@pytest.mark.parametrize("level", range(1, 11))
def test_the_chance_against_an_aerocraft_is_that_of_all_throws(level: int) -> None:
    hits = [adjudicate("aerocraft", level, 1, 0, roll, 0, 0) == 1 for roll in TWO_DICE]

    assert ODDS.odds_air[level] == pytest.approx(sum(hits) / 36)


@pytest.mark.parametrize(
    ("level", "blood", "armour", "mods", "losses"),
    [
        *[(8, 3, 2, 0, 1.98), (8, 3, 3, 0, 1.85), (8, 3, 4, 0, 1.44)],
        *[(8, 3, 2, -4, 1.53), (8, 3, 3, -4, 1.31), (8, 3, 4, -4, 0.59)],
        *[(5, 3, 4, 0, 0.86), (10, 1, 4, 0, 1.02)],
    ],
)
def test_a_shot_is_expected_to_destroy_what_the_rule_book_says(
    level: int, blood: int, armour: int, mods: int, losses: float
) -> None:
    """Rule book, section 7: expected losses."""
    chances = ODDS.odds_vehicle[armour, blood, level, mods + 8]

    assert round(float(chances[1:] @ np.arange(6)), 2) == losses


@pytest.mark.parametrize(("mods", "chance"), [(0, 0.81), (-4, 0.41)])
def test_a_good_shot_at_a_tank_destroys_something_as_often_as_the_rule_book_says(
    mods: int, chance: float
) -> None:
    assert round(float(ODDS.odds_vehicle[4, 3, 8, mods + 8, 2:].sum()), 2) == chance


def test_chances_sum_to_one_where_there_is_a_shot_and_to_nought_elsewhere() -> None:
    for chances in (ODDS.odds_vehicle[:, 1:, 1:], ODDS.odds_small[:, 1:], ODDS.odds_soldier[1:]):
        np.testing.assert_allclose(chances.sum(axis=-1), 1, atol=1e-6)
    for nothing in (ODDS.odds_vehicle[:, 0], ODDS.odds_vehicle[:, :, 0], ODDS.odds_small[:, 0]):
        assert not nothing.any()
    assert not ODDS.odds_soldier[0].any()
    assert ODDS.odds_air[0] == 0


def test_the_odds_follow_the_tables(misprint: Callable[..., RuleSet]) -> None:
    other = misprint("vehicle_result", 7, 14, entry=1).compiled()[0]

    assert (other.odds_vehicle[:, 3, 8] != ODDS.odds_vehicle[:, 3, 8]).any()
    assert (other.odds_soldier == ODDS.odds_soldier).all()
