"""Targets of temporal-difference learning: pure functions, one an equation."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from hexwar_sb3.players.terms import DECISION_TICKS


def row_discount(gamma: float, ticks: float) -> float:
    """Discount of a transition that took some ticks: gamma^(ticks / 75), so that Δt does not tune the horizon.

    The objective of eq. (4) is gamma = 1.
    """
    return float(gamma ** (ticks / DECISION_TICKS))


def qmix_target(
    reward: Float[Tensor, "batch reward"],
    terminated: Float[Tensor, "batch 1"],
    next_q_total: Float[Tensor, "batch value"],
    discount: Float[Tensor, "batch 1"],
) -> Float[Tensor, "batch value"]:
    """Target for the joint value: y = r_Σ + γ (1 − terminated) Q_Σ' (III-C; r_Σ is eq. (3)).

    Args:
        reward: team reward, or its n-step return, in scaled points [B, 1]; each agent's own [B, N].
        terminated: 1 where the game ended within these steps (not where it was cut short) [B, 1].
        next_q_total: target mixer's value of the masked greedy tasks [B, 1]; [B, N] without a mixer.
        discount: gamma^(ticks / 75) of the transition, or the product over n steps, in [0, 1] [B, 1].

    Returns:
        Targets in scaled points [B, 1] or [B, N].
    """
    return reward + discount * (1.0 - terminated) * next_q_total


def n_step_return(
    rewards: Float[Tensor, "batch step reward"],
    discounts: Float[Tensor, "batch step"],
    inside: Bool[Tensor, "batch step"],
) -> tuple[Float[Tensor, "batch reward"], Float[Tensor, "batch 1"]]:
    """Return over up to n steps: Σ_k (Π_{j<k} γ_j) r_k, and the discount Π_k γ_k of the state after it.

    Args:
        rewards: rewards of n steps in a row, of the team [B, n, 1] or of each agent [B, n, N].
        discounts: discount of each step [B, n].
        inside: False from the first step that is past the episode's end on [B, n].

    Returns:
        Return [B, 1] or [B, N], and discount [B, 1].
    """
    after = torch.where(inside, discounts, 1.0).cumprod(dim=1)
    before = torch.cat([torch.ones_like(after[:, :1]), after[:, :-1]], dim=1)
    return ((before * inside).unsqueeze(2) * rewards).sum(dim=1), after[:, -1:]


def lambda_returns(
    rewards: Float[Tensor, "batch step reward"],
    discounts: Float[Tensor, "batch step"],
    terminated: Float[Tensor, "batch step"],
    next_values: Float[Tensor, "batch step value"],
    inside: Bool[Tensor, "batch step"],
    lambda_: float,
) -> Float[Tensor, "batch step value"]:
    """λ-returns: G_t = r_t + γ_t (1 − terminated) ((1 − λ) Q'_{t+1} + λ G_{t+1}), each row from its own last step.

    Args:
        rewards: rewards of n steps in a row, of the team [B, n, 1] or of each agent [B, n, N].
        discounts: discount of each step [B, n].
        terminated: 1 where the game ended with the step [B, n].
        next_values: target networks' value of the state after each step [B, n, 1] ([B, n, N] without a mixer).
        inside: False from the first step that is past the episode's end on [B, n].
        lambda_: 0 is the one-step target, 1 the return itself.

    Returns:
        Targets [B, n, 1] or [B, n, N]; meaningless where not inside.
    """
    last = rewards.shape[1] - 1
    returns = torch.empty_like(next_values)
    for t in reversed(range(last + 1)):
        value = next_values[:, t]
        if t < last:
            mixed = (1.0 - lambda_) * value + lambda_ * returns[:, t + 1]
            value = torch.where(inside[:, t + 1, None], mixed, value)
        returns[:, t] = qmix_target(rewards[:, t], terminated[:, t, None], value, discounts[:, t, None])
    return returns
