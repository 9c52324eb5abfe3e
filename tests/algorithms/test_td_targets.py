"""Targets that can be added up by hand."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from hexwar_sb3.algorithms.td_targets import lambda_returns, n_step_return, qmix_target, row_discount


def column(*values: float) -> Tensor:
    return torch.tensor(values).unsqueeze(1)


def test_the_target_is_reward_plus_discounted_next_value() -> None:
    """The target y = r + γ (1 − terminated) Q' (III-C)."""
    target = qmix_target(column(1.0, 1.0), column(0.0, 1.0), column(10.0, 10.0), column(0.9, 0.9))

    assert target.tolist() == [[10.0], [1.0]]


def test_without_a_mixer_every_piece_has_its_own_target() -> None:
    target = qmix_target(column(1.0), column(0.0), torch.tensor([[10.0, 20.0]]), column(0.5))

    assert target.tolist() == [[6.0, 11.0]]


@pytest.mark.parametrize(("ticks", "discount"), [(75, 0.5), (150, 0.25), (0, 1.0)])
def test_gamma_is_the_discount_of_75_ticks(ticks: int, discount: float) -> None:
    assert row_discount(0.5, ticks) == discount


def test_the_return_of_three_steps() -> None:
    """1 + 0.5·2 + 0.5·0.1·4 = 2.2, and 0.5·0.1·0.2 of what comes after."""
    reward, discount = n_step_return(
        torch.tensor([[[1.0], [2.0], [4.0]]]),
        torch.tensor([[0.5, 0.1, 0.2]]),
        torch.ones(1, 3, dtype=torch.bool),
    )

    assert reward.item() == pytest.approx(2.2)
    assert discount.item() == pytest.approx(0.01)


def test_steps_past_the_end_of_the_episode_count_nothing() -> None:
    reward, discount = n_step_return(
        torch.tensor([[[1.0], [2.0], [4.0]]]),
        torch.tensor([[0.5, 0.1, 0.2]]),
        torch.tensor([[True, True, False]]),
    )

    assert reward.item() == pytest.approx(2.0)
    assert discount.item() == pytest.approx(0.05)


def test_every_row_of_a_batch_has_a_return_of_its_own() -> None:
    """One column each, as `qmix_target` takes them."""
    reward, discount = n_step_return(
        torch.tensor([[[1.0], [2.0]], [[3.0], [4.0]]]),
        torch.full((2, 2), 0.5),
        torch.ones(2, 2, dtype=torch.bool),
    )

    assert reward.tolist() == [[2.0], [5.0]]
    assert discount.tolist() == [[0.25], [0.25]]


def test_agents_with_rewards_of_their_own_have_returns_of_their_own() -> None:
    rewards, step = torch.tensor([[[1.0, 10.0], [2.0, 20.0]]]), torch.full((1, 2), 0.5)
    inside, values = torch.ones(1, 2, dtype=torch.bool), torch.tensor([[[4.0, 8.0], [40.0, 80.0]]])

    reward, discount = n_step_return(rewards, step, inside)
    assert reward.tolist() == [[2.0, 20.0]]
    assert discount.tolist() == [[0.25]]
    assert qmix_target(reward, torch.zeros(1, 1), values[:, 1], discount).tolist() == [[12.0, 40.0]]
    assert lambda_returns(rewards, step, torch.zeros(1, 2), values, inside, 1.0).tolist() == [
        [[12.0, 40.0], [22.0, 60.0]]
    ]


def returns(lambda_: float, terminated: tuple[float, ...], inside: tuple[bool, ...]) -> list[float]:
    """λ-returns of rewards 1, 2, 4 with γ = 0.5 and next values 10, 20, 40."""
    values = torch.tensor([[10.0, 20.0, 40.0]]).unsqueeze(2)
    result = lambda_returns(
        torch.tensor([[[1.0], [2.0], [4.0]]]),
        torch.full((1, 3), 0.5),
        torch.tensor([terminated]),
        values,
        torch.tensor([inside]),
        lambda_,
    )
    return [float(value) for value in result.flatten()]


def test_lambda_zero_is_the_one_step_target() -> None:
    assert returns(0.0, (0, 0, 0), (True, True, True)) == [6.0, 12.0, 24.0]


def test_lambda_one_is_the_return_itself() -> None:
    """G_3 = 4 + 20; G_2 = 2 + 12; G_1 = 1 + 7."""
    assert returns(1.0, (0, 0, 0), (True, True, True)) == [8.0, 14.0, 24.0]


def test_lambda_between_mixes_value_and_return() -> None:
    """G_3 = 24; G_2 = 2 + 0.5 (0.5·20 + 0.5·24) = 13; G_1 = 1 + 0.5 (0.5·10 + 0.5·13) = 6.75."""
    assert returns(0.5, (0, 0, 0), (True, True, True)) == [6.75, 13.0, 24.0]


def test_lambda_returns_start_from_each_episodes_own_last_step() -> None:
    """The game ended with step 2: G_2 = 2, G_1 = 1 + 1; what lies behind it is another game."""
    assert returns(1.0, (0, 1, 0), (True, True, False))[:2] == [2.0, 2.0]


def test_a_window_that_is_cut_short_goes_on_with_the_next_value() -> None:
    """Step 2 is the newest: G_2 = 2 + 0.5·20, G_1 = 1 + 0.5·12."""
    assert returns(1.0, (0, 0, 0), (True, True, False))[:2] == [7.0, 12.0]
