"""A model goes on from a frozen policy: its values stay, also in a wider network."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.frozen import FrozenPolicy


def model(seed: int = 0, **widths: int) -> QMIX:
    env = make_vec_env(n_envs=4, seed=1, privileged_state=True)
    return QMIX("TaskPolicy", env, seed=seed, buffer_size=500, learning_starts=0, policy_kwargs=widths)


@pytest.mark.parametrize("widths", [{}, {"hidden": 96}, {"embed": 40}, {"hidden": 128, "embed": 64}])
def test_values_stay(widths: dict[str, int]) -> None:
    policy, wide = model(seed=1).policy.freeze(), model(seed=2, **widths)
    wide.take_over(policy)
    obs = wide.env.reset()  # type: ignore[union-attr]
    values = policy.q_values(obs)  # type: ignore[arg-type]
    for mine in (wide.policy.freeze(), wide.policy.freeze()):
        np.testing.assert_allclose(mine.q_values(obs), values, rtol=1e-4, atol=1e-5)  # type: ignore[arg-type]
        np.testing.assert_array_equal(mine.act(obs), policy.act(obs))  # type: ignore[arg-type]


def test_new_units_learn() -> None:
    wide = model(hidden=128)
    wide.take_over(model(seed=1).policy.freeze())
    before = wide.policy.agent.state_dict()["value.weight"][:, 64:].clone()
    wide.learn(4 * 24 * 4)

    assert torch.equal(before, torch.zeros_like(before))
    after = wide.policy.agent.state_dict()["value.weight"][:, 64:]
    assert (after != 0).float().mean() > 0.8  # a unit may be at rest in all that was seen


@pytest.mark.parametrize(
    ("mine", "message"),
    [
        ({"hidden": 32}, r"piece.weight: the policy has \(64, \d+\), this model \(32, \d+\)"),
        ({"embed": 16}, r"embed_piece.weight: the policy has \(32, 64\), this model \(16, 64\)"),
    ],
)
def test_a_wider_policy_is_refused(mine: dict[str, int], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        model(**mine).take_over(model().policy.freeze())


def test_a_policy_of_other_features_is_refused() -> None:
    policy = model().policy.freeze()
    weights = {**policy.weights, "piece.weight": np.zeros((64, 3), np.float32)}
    other = FrozenPolicy(weights, n_pieces=policy.n_pieces, n_tasks=policy.n_tasks)
    with pytest.raises(ConfigError, match=r"piece.weight: the policy has \(64, 3\)"):
        model().take_over(other)
