"""Standing orders: who is ordered where, from when on, and what a led policy then plays and thinks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LEAD, LedPolicy, StandingOrder, standing_orders
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.features import index
from hexwar_sb3.tasks.records import TaskKind

TIME_LEFT = index("obs", 7, 7, 2)["game: time left"].start


@pytest.fixture(scope="module")
def policy() -> FrozenPolicy:
    return QMIX("TaskPolicy", make_vec_env(n_envs=1, seed=0), seed=3, buffer_size=10).policy.freeze()


@pytest.fixture
def obs() -> dict[str, NDArray[Any]]:
    """The first decision of three games."""
    first: Any = make_vec_env(n_envs=3, seed=1).reset()
    return {key: value.copy() for key, value in first.items()}


def holds(obs: dict[str, NDArray[Any]], piece: int) -> list[int]:
    """Valid tasks of a piece in the first game that hold a spot."""
    rows = (obs["tasks"][0, piece, :, TaskKind.HOLD] == 1) & (obs["action_mask"][0, piece] == 1)
    return [int(row) for row in np.flatnonzero(rows)]


def test_pieces_that_are_ordered_hold_that_spot_and_the_others_do_as_the_policy_says(
    policy: FrozenPolicy, obs: dict[str, NDArray[Any]]
) -> None:
    free = policy.act(obs)
    led = LedPolicy(policy, StandingOrder(pieces=(0, 3), spot=2, ticks_left=1800)).act(obs)

    assert led[:, 0].tolist() == [holds(obs, 0)[2]] * 3
    assert led[:, 3].tolist() == [holds(obs, 3)[2]] * 3
    others = [1, 2, 4, 5, 6]
    np.testing.assert_array_equal(led[:, others], free[:, others])


def test_a_spot_is_counted_among_those_that_the_piece_can_hold(
    policy: FrozenPolicy, obs: dict[str, NDArray[Any]]
) -> None:
    first, second, *_ = holds(obs, 0)
    obs["action_mask"][:, 0, first] = 0
    order = StandingOrder(pieces=(0,), spot=0, ticks_left=1800)

    assert LedPolicy(policy, order).act(obs)[0, 0] == second


def test_an_order_that_a_piece_cannot_follow_is_none(
    policy: FrozenPolicy, obs: dict[str, NDArray[Any]]
) -> None:
    order = StandingOrder(pieces=(0,), spot=39, ticks_left=1800)
    np.testing.assert_array_equal(LedPolicy(policy, order).act(obs), policy.act(obs))
    np.testing.assert_array_equal(LedPolicy(policy, order).q_values(obs), policy.q_values(obs))


def test_the_policy_is_free_until_its_time(obs: dict[str, NDArray[Any]]) -> None:
    """1500 ticks are left in the second game, 1575 in the others; a dead piece's own row says nothing of it."""
    obs["obs"][:, :, TIME_LEFT] = np.array([1575, 1500, 1575], np.float32)[:, None] / 1800
    obs["obs"][:, 4] = 0
    order = StandingOrder(pieces=(0,), spot=0, ticks_left=1500)
    games = [games.tolist() for _, games, _ in order.rows(obs)]

    assert games == [[1]]


def test_an_ordered_task_is_thought_the_best_by_far(
    policy: FrozenPolicy, obs: dict[str, NDArray[Any]]
) -> None:
    led = LedPolicy(policy, StandingOrder(pieces=(0, 1, 2), spot=1, ticks_left=1800))
    q, free = led.q_values(obs), policy.q_values(obs)

    np.testing.assert_array_equal(q.argmax(axis=2), led.act(obs))
    np.testing.assert_allclose(q[:, :3].max(axis=2), free[:, :3].max(axis=2) + LEAD, rtol=1e-6)
    assert (q != free).sum() == 9


def test_squads_are_all_vehicles_of_a_kind_or_of_both_or_the_first_of_each() -> None:
    found = standing_orders(load_world("plain").scenario, Camp.BLUE, spots=3, free_ticks=300)
    squads = {order.pieces for order in found}

    assert squads == {(0, 1), (2, 3), (0, 1, 2, 3), (0,), (2,), (0, 2)}
    assert len(found) == 3 * len(squads)
    assert {order.spot for order in found} == {0, 1, 2}
    assert {order.ticks_left for order in found} == {1500}
