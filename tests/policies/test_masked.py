"""Networks that value only the valid actions of a mask."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import spaces
from torch import Tensor

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies.masked import (
    MASKED_VALUE,
    MaskedDQNPolicy,
    MaskedQRDQNPolicy,
    check_masked_spaces,
    fill_masked,
)

A = 4
SPACE = spaces.Dict(
    {
        "cell": spaces.Box(-1.0, 1.0, (2, 3)),
        "action_mask": spaces.Box(0, 1, (A,), np.int8),
        "zeal": spaces.Box(0.0, 1.0, (1,)),
    }
)
ACTIONS = spaces.Discrete(A)
Policy = MaskedDQNPolicy | MaskedQRDQNPolicy


@pytest.fixture(params=[MaskedDQNPolicy, MaskedQRDQNPolicy])
def policy(request: pytest.FixtureRequest) -> Policy:
    torch.manual_seed(0)
    options: dict[str, Any] = {} if request.param is MaskedDQNPolicy else {"n_quantiles": 200}
    return request.param(SPACE, ACTIONS, lambda _: 1e-3, **options)


def network(policy: Policy) -> torch.nn.Module:
    return policy.q_net if isinstance(policy, MaskedDQNPolicy) else policy.quantile_net


def mean_values(policy: Policy, observation: dict[str, Tensor]) -> Tensor:
    """Q [B, A]; of quantiles the mean."""
    values: Tensor = network(policy)(observation)
    return values if values.ndim == 2 else values.mean(dim=1)


def situations(*masks: list[int]) -> dict[str, Tensor]:
    """The same situation with some masks."""
    b = len(masks)
    return {
        "action_mask": torch.tensor(masks, dtype=torch.int8),
        "cell": torch.full((b, 2, 3), 0.5),
        "zeal": torch.ones(b, 1),
    }


def test_the_mask_is_no_feature(policy: Policy) -> None:
    free, narrow = mean_values(policy, situations([1, 1, 1, 1], [0, 1, 0, 1]))

    assert network(policy).features_dim == 7
    assert policy.net_arch == [64, 64]
    torch.testing.assert_close(free[[1, 3]], narrow[[1, 3]])


def test_an_invalid_action_has_a_large_negative_value(policy: Policy) -> None:
    values = mean_values(policy, situations([0, 1, 0, 1]))[0]

    assert torch.isfinite(values).all()
    assert values[[0, 2]].tolist() == pytest.approx([MASKED_VALUE] * 2)
    assert (values[[1, 3]].abs() < 10).all()


def test_a_mask_of_zeros_masks_nothing(policy: Policy) -> None:
    """A last observation without valid actions is valued all the same, if the episode was cut short."""
    free, none = mean_values(policy, situations([1, 1, 1, 1], [0, 0, 0, 0]))

    torch.testing.assert_close(free, none)


@pytest.mark.parametrize("best", range(A))
def test_the_only_valid_action_is_picked(policy: Policy, best: int) -> None:
    mask = [int(action == best) for action in range(A)]

    assert policy(situations(mask)).tolist() == [best]
    one = {key: values[0].numpy() for key, values in situations(mask).items()}
    assert policy.predict(one, deterministic=False)[0] == best


def test_an_invalid_action_gets_no_gradient() -> None:
    values = torch.zeros(1, 3, requires_grad=True)

    fill_masked(values, torch.tensor([[1, 0, 1]])).sum().backward()  # type: ignore[no-untyped-call]

    assert values.grad is not None
    assert values.grad.tolist() == [[1, 0, 1]]


def test_targets_are_networks_of_the_same_kind(policy: Policy) -> None:
    target = policy.q_net_target if isinstance(policy, MaskedDQNPolicy) else policy.quantile_net_target
    observation = situations([0, 1, 1, 0])

    torch.testing.assert_close(target(observation), network(policy)(observation))


def box(*shape: int) -> spaces.Box:
    return spaces.Box(0.0, 1.0, shape)


@pytest.mark.parametrize(
    ("observation_space", "action_space", "message"),
    [
        (SPACE, box(A), r"must be Discrete and count from 0, got Box"),
        (SPACE, spaces.Discrete(A, start=1), r"must be Discrete and count from 0, got Discrete"),
        (box(3), ACTIONS, "must be a Dict with the key 'action_mask', got Box"),
        (spaces.Dict({"cell": box(3)}), ACTIONS, "must be a Dict with the key 'action_mask', got Dict"),
        (
            spaces.Dict({"cell": box(3), "action_mask": box(3)}),
            ACTIONS,
            r"must be \(4,\), one number an action; got \(3,\)",
        ),
        (spaces.Dict({"action_mask": box(4)}), ACTIONS, "nothing beside 'action_mask'"),
    ],
)
def test_spaces_without_a_mask_of_the_actions_are_refused(
    observation_space: spaces.Space[Any], action_space: spaces.Space[Any], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        check_masked_spaces(observation_space, action_space)
