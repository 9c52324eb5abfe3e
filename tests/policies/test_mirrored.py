"""Networks that do not see which camp they play."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.tasks.features import feature_index, sizes
from tests.envs.matrix_games import TwoStepGame


@pytest.mark.parametrize("with_state", [True, False])
@pytest.mark.parametrize("network", ["additive", "literal"])
def test_another_camp_changes_nothing_before_and_after_learning(with_state: bool, network: str) -> None:
    env = make_vec_env("HexWarTask-v0", n_envs=4, seed=0, side="both", privileged_state=with_state)
    kwargs = {"mirrored": True, "network": network}
    model = QMIX("TaskPolicy", env, seed=0, learning_starts=10, batch_size=16, policy_kwargs=kwargs)
    for steps in (4, 4 * 60):
        model.learn(steps)
        assert _differences(model) == (0.0, 0.0)
    assert model._n_updates > 0


def test_else_the_camp_is_seen() -> None:
    env = make_vec_env("HexWarTask-v0", n_envs=4, seed=0, side="both", privileged_state=True)
    own, mixed = _differences(QMIX("TaskPolicy", env, seed=0).learn(4))

    assert own > 0.0
    assert mixed > 0.0


def _differences(model: QMIX) -> tuple[float, float]:
    """How far the values of agents and mixer are apart with the camp's features changed."""
    policy, obs = model.policy, model.replay_buffer.sample(32, 1, np.random.default_rng(0)).now
    assert isinstance(policy, TaskPolicy)
    blue = feature_index("obs", 7, 7, 2)["game: blue"]
    assert blue.stop == obs.sets.obs.shape[1]
    other = type(obs.sets)(
        obs.sets.obs.clone(), obs.sets.tasks, obs.sets.piece, obs.sets.task, obs.sets.n_tasks
    )
    other.obs[:, blue] = 1.0 - other.obs[:, blue]
    state = obs.state.clone()
    assert feature_index("state", 7, 7, 2)["game: blue"].stop in (state.shape[1], sizes(7, 7, 2).state)
    width = policy.shapes.obs_dim
    columns = range(width - 1, state.shape[1], width) if state.shape[1] == 7 * width else [state.shape[1] - 1]
    state[:, list(columns)] = 1.0 - state[:, list(columns)]
    with torch.no_grad():
        q = policy.agent.q_values(obs.sets), policy.agent.q_values(other)
        agent_q = torch.ones_like(obs.alive)
        mixed = [policy.mixer(agent_q, one, obs.alive) for one in (obs.state, state)]
    return float((q[0] - q[1]).abs().max()), float((mixed[0] - mixed[1]).abs().max())


def test_a_frozen_copy_plays_both_camps_alike() -> None:
    env = make_vec_env("HexWarTask-v0", n_envs=4, seed=0, side="both", privileged_state=True)
    model = QMIX(
        "TaskPolicy", env, seed=0, policy_kwargs={"mirrored": True}, learning_starts=10, batch_size=16
    )
    frozen = model.learn(4 * 48).policy.freeze()

    assert not frozen.weights["piece.weight"][:, feature_index("obs", 7, 7, 2)["game: blue"]].any()


def test_a_preset_mirrors_where_the_map_does() -> None:
    widths = {"hidden": 128}
    assert PRESETS["default"].learner_for(10, "plain")["policy_kwargs"] == {"mirrored": True, **widths}
    assert PRESETS["paper"].learner_for(10, "plain")["policy_kwargs"] == {"mirrored": False}
    seen = PRESETS["default"].changed({"mirrored": False})
    assert seen.learner_for(10, "plain")["policy_kwargs"] == {"mirrored": False, **widths}


def test_another_env_is_refused() -> None:
    with pytest.raises(ConfigError, match="mirrored networks are for the task env"):
        QMIX("TaskPolicy", JointActionEnv(TwoStepGame()), policy_kwargs={"mirrored": True})
