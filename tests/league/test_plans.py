"""Plans: an order is for all opponents that look alike when it begins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.league.plans import Plan, Planner, Planning, tell_apart
from hexwar_sb3.league.work import job_seed
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder

GAME = 1800
EARLY = StandingOrder(pieces=(0, 1), spot=5, ticks_left=GAME - 300)
LATE = replace(EARLY, ticks_left=GAME - 450)
OTHER = replace(EARLY, spot=2)
QUICK = Planning(trials=((2, 3), (5, 1)), enough=0.95, sights=4)
Rates = dict[str, dict[StandingOrder | None, float]]  # by opponent and order; else the first number


@pytest.fixture
def policy(starters: dict[str, Path]) -> FrozenPolicy:
    return FrozenPolicy.load(starters["one"])


def planner(
    policy: FrozenPolicy, looks: dict[str, list[int]], rates: Rates, planning: Planning = QUICK
) -> tuple[Planner, list[StandingOrder | None]]:
    """Make one whose opponents look like this number at each time, with results that are known; who has played."""
    terms = Terms(games=1)
    played: list[StandingOrder | None] = []
    found = Planner(policy, "red", [(name, 0.5) for name in looks], planning, terms)
    kinds = [[np.full((4, 2), number, np.float32) for number in numbers] for numbers in looks.values()]
    found.__dict__["_sights"] = kinds

    def play(player: object, group: tuple[int, ...], *_: int) -> dict[int, float]:
        order = player.order if isinstance(player, LedPolicy) else None
        played.append(order)
        known = [rates[list(looks)[k]] for k in group]
        return {k: one.get(order, 0.0) for k, one in zip(group, known, strict=True)}

    found.__dict__["_play"] = play
    return found, played


def test_an_order_begins_as_soon_as_its_opponent_shows(policy: FrozenPolicy) -> None:
    rates: Rates = {"MA1": {None: 0.5, EARLY: 0.9, LATE: 0.8}, "MA2": {None: 0.7}}
    found, _ = planner(policy, {"MA1": [1, 1], "MA2": [2, 2]}, rates)

    assert found.plan() == Plan((EARLY, None), (0.9, 0.7))


def test_it_waits_until_its_opponent_shows(policy: FrozenPolicy) -> None:
    rates: Rates = {"MA1": {None: 0.5, EARLY: 0.9, LATE: 0.8}, "MA2": {None: 0.7}}
    found, _ = planner(policy, {"MA1": [1, 1], "MA2": [1, 2]}, rates)

    assert found.plan() == Plan((LATE, None), (0.8, 0.7))


def test_those_who_never_show_have_one_order_together(policy: FrozenPolicy) -> None:
    rates: Rates = {"MA1": {None: 0.1, EARLY: 0.9}, "MA2": {None: 0.1, OTHER: 0.5, EARLY: 0.0}}
    rates["MA1"][OTHER] = 0.6
    found, _ = planner(policy, {"MA1": [1, 1], "MA2": [1, 1]}, rates)

    assert found.plan() == Plan((OTHER, OTHER), (0.6, 0.5))


def test_who_looks_like_a_third_is_in_its_group(policy: FrozenPolicy) -> None:
    found, _ = planner(policy, {"MA1": [1, 1], "MA2": [3, 3], "defender": [1, 1]}, {})
    middle = [np.stack([found._sights[k][0][0] for k in (0, 0, 1, 1)])] * 2
    found.__dict__["_sights"][2] = middle

    assert found._alike((0, 1), 300) == [(0,), (1,)]
    assert found._alike((0, 1, 2), 300) == [(0, 1, 2)]


@pytest.mark.parametrize(("rate", "order"), [(0.52, None), (0.54, EARLY)])
def test_an_order_must_bring_something(
    policy: FrozenPolicy, rate: float, order: StandingOrder | None
) -> None:
    found, _ = planner(policy, {"MA1": [1, 1]}, {"MA1": {None: 0.5, EARLY: rate}})

    assert found.plan().orders == (order,)


def test_where_nearly_all_is_won_nothing_is_tried(policy: FrozenPolicy) -> None:
    found, played = planner(policy, {"MA1": [1, 1]}, {"MA1": {None: 0.96, EARLY: 1.0}})

    assert found.plan() == Plan((None,), (0.96,))
    assert played == [None]


def test_the_better_orders_of_a_trial_go_on(policy: FrozenPolicy) -> None:
    found, played = planner(
        policy, {"MA1": [1]}, {"MA1": {None: 0.5, EARLY: 0.9}}, replace(QUICK, times=(300,))
    )
    found.plan()

    assert len([one for one in played if one is not None]) == 6 * 8 + 3


def test_times_after_the_end_are_left_out(policy: FrozenPolicy) -> None:
    found, _ = planner(policy, {"MA1": []}, {"MA1": {None: 0.5}}, replace(QUICK, times=(GAME, 2 * GAME)))

    assert found.plan() == Plan((None,), (0.5,))


def test_who_plays_alike_is_not_told_apart(policy: FrozenPolicy) -> None:
    """Real games: the same bot twice, and one that comes against one that stays."""
    opponents = [("nearest", 1.0), ("nearest", 1.0), ("defender", 1.0)]
    found = Planner(policy, "blue", opponents, Planning(times=(75, 900), sights=16), Terms(games=1))
    first, second = found._alike((0, 1), 900), found._alike((0, 2), 900)

    assert first == [(0, 1)]
    assert second == [(0,), (2,)]
    assert found._sights[0].shape == (2, 16, 7 * 257)
    assert found._alike((0, 1, 2), 75) == [(0, 1, 2)]


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_policies_play_in_their_own_camp(camp: str, policy: FrozenPolicy) -> None:
    terms = Terms(games=8, seed=job_seed(0, 0))
    as_red, as_blue = terms.play(policy, "nearest").red, terms.play("nearest", policy).blue
    expected = as_red if camp == "red" else as_blue
    found = Planner(policy, camp, [("nearest", 1.0)], QUICK, Terms(games=1))

    assert found._play(policy, (0,), 8, 0) == {0: expected.win_rate.value}


@pytest.mark.parametrize(("apart", "share"), [(0.0, 0.5), (1.0, 1.0)])
def test_nearest_neighbours_tell_kinds_apart(apart: float, share: float) -> None:
    same = np.zeros((5, 3), np.float32)

    assert tell_apart(same, same + np.float32(apart)) == share


def test_noise_is_not_a_kind() -> None:
    def noise(seed: int) -> Any:
        return np.random.default_rng(seed).normal(size=(64, 4)).astype(np.float32)

    assert 0.3 < tell_apart(noise(1), noise(2)) < 0.7
    assert tell_apart(noise(1), noise(2) + 20) == 1.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"times": (0,)},
        {"times": (450, 300)},
        {"trials": ((0, 1),)},
        {"trials": ((1, 0),)},
        {"sights": 1},
        {"gain": 2.0},
        {"enough": -1.0},
    ],
)
def test_a_wrong_number_is_named(wrong: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match=next(iter(wrong))[:4]):
        Planning(**wrong)
