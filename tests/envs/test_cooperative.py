"""Games of other kinds than PettingZoo's: tuples for each agent, and lists as SMAC has them."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo.test import parallel_api_test

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.cooperative import ListGame, TupleGame, as_parallel
from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.errors import ConfigError

LENGTH = 4


class Tuples(gymnasium.Env[Any, Any]):
    """Three agents with 2, 3 and 2 actions; each is paid its own action; over after four steps."""

    def __init__(self, masked: bool = False, flags: type = bool) -> None:
        self.masked, self.flags, self.moment = masked, flags, 0
        self.action_space: Any = spaces.Tuple([spaces.Discrete(n) for n in (2, 3, 2)])
        self.observation_space: Any = spaces.Tuple([spaces.Box(0.0, 9.0, (n,)) for n in (1, 2, 1)])

    def seen(self) -> tuple[tuple[NDArray[np.float32], ...], dict[str, Any]]:
        masks = [[1, 0], [1, 1, 0], [1, 1]]
        seen = tuple(np.full(n, self.moment, np.float32) for n in (1, 2, 1))
        return seen, {"action_mask": masks} if self.masked else {}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        super().reset(seed=seed)
        self.moment = 0
        return self.seen()

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, Any]:
        self.moment += 1
        seen, info = self.seen()
        over = self.moment == LENGTH
        rewards = [float(one) for one in action]
        return seen, rewards, over if self.flags is bool else [over] * 3, False, info


class Lists:
    """Two agents that see their number; the second action is there from the second step on; out of time after four steps."""

    def __init__(self) -> None:
        self.moment = 0

    def get_env_info(self) -> dict[str, Any]:
        return {"n_agents": 2, "n_actions": 2, "obs_shape": 1, "state_shape": 3, "episode_limit": LENGTH}

    def reset(self) -> tuple[Any, Any]:
        self.moment = 0
        return self.get_obs(), self.get_state()

    def step(self, actions: Any) -> tuple[float, bool, dict[str, Any]]:
        self.moment += 1
        over = self.moment == LENGTH
        return float(sum(actions)), over, {"episode_limit": True} if over else {}

    def get_obs(self) -> list[NDArray[np.float32]]:
        return [np.full(1, k, np.float32) for k in range(2)]

    def get_state(self) -> NDArray[np.float32]:
        return np.full(3, self.moment, np.float32)

    def get_avail_actions(self) -> list[list[int]]:
        return [[1, int(self.moment > 0)]] * 2


@pytest.mark.parametrize("game", [TupleGame(Tuples()), TupleGame(Tuples(masked=True)), ListGame(Lists())])
def test_they_are_parallel_envs(game: Any) -> None:
    parallel_api_test(game, num_cycles=20)


@pytest.mark.parametrize("flags", [bool, list])
def test_tuples_are_dealt_out_to_agents(flags: type) -> None:
    """The episode ends with a flag for all, or with the last agent's."""
    env = JointActionEnv(Tuples(flags=flags), team_reward="sum")
    obs, _ = env.reset(seed=0)
    assert obs["action_mask"].tolist() == [[1, 1, 0], [1, 1, 1], [1, 1, 0]]
    assert "state" not in obs

    played = [env.step(np.array([1, 2, 0])) for _ in range(LENGTH)]

    assert [step[1] for step in played] == [3.0] * LENGTH
    assert [step[2:4] for step in played] == [(False, False)] * (LENGTH - 1) + [(True, False)]


def test_masks_of_tuples_are_read() -> None:
    obs, _ = JointActionEnv(Tuples(masked=True)).reset(seed=0)
    assert obs["action_mask"].tolist() == [[1, 0, 0], [1, 1, 0], [1, 1, 0]]


def test_lists_have_masks_a_state_and_a_time_limit() -> None:
    env = JointActionEnv(Lists())
    obs, _ = env.reset()
    assert obs["action_mask"].tolist() == [[1, 0], [1, 0]]

    obs, reward, *_ = env.step(np.array([0, 0]))
    assert obs["action_mask"].tolist() == [[1, 1], [1, 1]]
    assert (obs["state"].tolist(), reward) == ([1.0] * 3, 0.0)
    played = [env.step(np.array([1, 1])) for _ in range(LENGTH - 1)]

    assert [step[1] for step in played] == [2.0] * (LENGTH - 1)
    assert [step[2:4] for step in played] == [(False, False)] * (LENGTH - 2) + [(False, True)]


def test_qmix_learns_in_a_game_of_lists() -> None:
    model = QMIX(
        "TaskPolicy", JointActionEnv(Lists()), learning_starts=10, train_freq=4, seed=0, device="cpu"
    )
    assert model.learn(60)._n_updates > 0


def test_what_is_none_of_these_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"with get_avail_actions\(\); got int"):
        as_parallel(3)
    odd = Tuples()
    odd.observation_space = spaces.Box(0.0, 1.0, (3,))
    with pytest.raises(ConfigError, match="needs a Tuple of observations"):
        as_parallel(odd)
    odd.observation_space = spaces.Tuple([spaces.Box(0.0, 1.0, (3,))])
    with pytest.raises(ConfigError, match="3 agents act, 1 see"):
        as_parallel(odd)
