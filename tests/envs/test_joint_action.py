"""JointActionEnv: any cooperative PettingZoo parallel env as one env with task sets."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv
from pettingzoo.test import parallel_api_test
from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.replay import situation_of
from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.errors import ConfigError, UnknownNameError
from tests.envs.matrix_games import CLIMBING, ROUNDS, RepeatedGame, TwoStepGame


class UnevenGame(ParallelEnv):  # type: ignore[misc]  # PettingZoo ships no types
    """Agents of different sizes; b's actions start at 5; a leaves after its first step; cut after three."""

    metadata = {"name": "uneven_v0"}  # noqa: RUF012

    def __init__(self, masks_in: str = "observation") -> None:
        self.possible_agents = ["a", "b"]
        self.agents: list[str] = []
        self.masks_in, self.moment = masks_in, 0
        self.played: list[dict[str, int]] = []

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        box = spaces.Box(0.0, 9.0, (2,) if agent == "a" else (1, 3))
        n = self.action_space(agent).n
        if self.masks_in == "observation":
            return spaces.Dict({"observation": box, "action_mask": spaces.Box(0, 1, (n,), np.int8)})
        return box

    def action_space(self, agent: str) -> spaces.Discrete:
        return spaces.Discrete(2) if agent == "a" else spaces.Discrete(3, start=5)

    def look(self) -> tuple[dict[str, Any], dict[str, Any]]:
        seen = {"a": np.full(2, self.moment, np.float32), "b": np.full((1, 3), self.moment, np.float32)}
        masks = {"a": np.array([0, 1], np.int8), "b": np.array([1, 0, 1], np.int8)}
        if self.masks_in == "observation":
            both = {name: {"observation": seen[name], "action_mask": masks[name]} for name in self.agents}
            return both, {name: {} for name in self.agents}
        infos = {
            name: {"action_mask": masks[name]} if self.masks_in == "infos" else {} for name in self.agents
        }
        return {name: seen[name] for name in self.agents}, infos

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        self.agents, self.moment = ["a", "b"], 0
        return self.look()

    def step(self, actions: dict[str, int]) -> tuple[Any, Any, Any, Any, Any]:
        self.played.append(actions)
        self.moment += 1
        seen, infos = self.look()
        rewards = {name: 1.0 if name == "a" else 2.0 for name in self.agents}
        ended = {name: name == "a" for name in self.agents}
        cut = dict.fromkeys(self.agents, self.moment == 3)
        self.agents = [name for name in self.agents if not ended[name] and not cut[name]]
        return seen, rewards, ended, cut, infos


class Endless(ParallelEnv):  # type: ignore[misc]  # PettingZoo ships no types
    """Two agents get 1 a step, whatever they do; cut after five."""

    metadata = {"name": "endless_v0"}  # noqa: RUF012
    possible_agents = ["a", "b"]  # noqa: RUF012

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        return spaces.Box(0.0, 1.0, (1,))

    def action_space(self, agent: str) -> spaces.Discrete:
        return spaces.Discrete(2)

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        self.agents, self.moment = ["a", "b"], 0
        return dict.fromkeys(self.agents, np.ones(1, np.float32)), {"a": {}, "b": {}}

    def step(self, actions: dict[str, int]) -> tuple[Any, Any, Any, Any, Any]:
        self.moment += 1
        cut = self.moment == 5
        self.agents = [] if cut else ["a", "b"]
        each = dict.fromkeys(self.possible_agents, 1.0)
        seen = dict.fromkeys(self.possible_agents, np.ones(1, np.float32))
        return seen, each, dict.fromkeys(each, False), dict.fromkeys(each, cut), {"a": {}, "b": {}}


def space_of(env: JointActionEnv) -> spaces.Dict:
    return cast("spaces.Dict", env.observation_space)


def test_the_matrix_games_are_parallel_envs() -> None:
    parallel_api_test(TwoStepGame(), num_cycles=20)
    parallel_api_test(RepeatedGame(CLIMBING), num_cycles=60)


def test_the_joint_env_passes_sb3s_checker() -> None:
    check_env(JointActionEnv(TwoStepGame()), warn=False)


def test_sizes_are_those_of_the_largest_agent() -> None:
    env = JointActionEnv(UnevenGame())

    assert env.action_space == spaces.MultiDiscrete([3, 3])
    assert space_of(env)["obs"].shape == (2, 3 + 2)
    assert "state" not in space_of(env).spaces


def test_an_observation_is_padded_and_names_its_agent() -> None:
    env = JointActionEnv(UnevenGame())
    env.reset()
    obs, *_ = env.step(np.array([1, 0]))

    assert obs["obs"].tolist() == [[1, 1, 0, 1, 0], [1, 1, 1, 0, 1]]
    assert obs["tasks"][1].tolist() == np.eye(3).tolist()


@pytest.mark.parametrize(
    ("masks_in", "mask"),
    [
        ("observation", [[0, 1, 0], [1, 0, 1]]),
        ("infos", [[0, 1, 0], [1, 0, 1]]),
        ("none", [[1, 1, 0], [1, 1, 1]]),
    ],
)
def test_masks_come_from_the_observation_or_the_infos(masks_in: str, mask: list[list[int]]) -> None:
    obs, _ = JointActionEnv(UnevenGame(masks_in)).reset()

    assert obs["action_mask"].tolist() == mask


def test_an_agent_that_left_is_dead_and_acts_no_more() -> None:
    game = UnevenGame()
    env = JointActionEnv(game)
    env.reset()

    obs, *_ = env.step(np.array([1, 2]))
    env.step(np.array([0, 0]))

    assert obs["alive"].tolist() == [0, 1]
    assert obs["action_mask"][0].tolist() == [1, 0, 0]
    assert game.played == [{"a": 1, "b": 7}, {"b": 5}]


@pytest.mark.parametrize(("team_reward", "rewards"), [("mean", [1.5, 2.0]), ("sum", [3.0, 2.0])])
def test_the_team_gets_the_mean_or_the_sum(team_reward: str, rewards: list[float]) -> None:
    env = JointActionEnv(UnevenGame(), team_reward=team_reward)
    env.reset()

    assert [env.step(np.array([1, 0]))[1] for _ in range(2)] == rewards


def test_a_cut_game_is_truncated_a_finished_one_terminated() -> None:
    env = JointActionEnv(UnevenGame())
    env.reset()
    assert [env.step(np.array([1, 0]))[2:4] for _ in range(3)] == [
        (False, False),
        (False, False),
        (False, True),
    ]

    game = JointActionEnv(RepeatedGame(CLIMBING))
    game.reset()
    ends = [game.step(np.array([0, 0]))[2:4] for _ in range(ROUNDS)]
    assert ends == [(False, False)] * (ROUNDS - 1) + [(True, False)]


def test_nobody_died_of_a_time_limit() -> None:
    """What is seen last is valued: those who were cut off live on in it, with their masks; who left before does not."""
    env = JointActionEnv(UnevenGame())
    env.reset()
    for _ in range(3):
        obs, *_ = env.step(np.array([1, 0]))

    assert obs["alive"].tolist() == [0.0, 1.0]
    assert obs["action_mask"].tolist() == [[1, 0, 0], [1, 0, 1]]


@pytest.mark.slow
@pytest.mark.parametrize("mixer", ["vdn", "qmix"])
def test_a_game_without_an_end_is_worth_more_than_until_its_time_limit(mixer: str) -> None:
    """1 a step for ever, discounted by 0.9, is worth 10; in the 5 steps until the cut it brings 4.1."""
    env = make_vec_env(lambda: JointActionEnv(Endless()), n_envs=4, seed=0)
    model = QMIX(
        *("TaskPolicy", env, 2e-3, 2_000),
        learning_starts=50,
        batch_size=64,
        tau=0.05,
        gamma=0.9,
        train_freq=(1, "step"),
        mixer=mixer,
        n_steps=2,
        reward_scale=1.0,
        seed=0,
    ).learn(4_000)

    start = situation_of(cast("dict[str, NDArray[Any]]", env.reset()), model.device)

    assert model.learner.first_value(start).mean().item() == pytest.approx(10.0, abs=0.3)


def test_the_state_may_be_left_out() -> None:
    assert space_of(JointActionEnv(TwoStepGame()))["state"].shape == (3,)
    assert "state" not in space_of(JointActionEnv(TwoStepGame(), privileged_state=False)).spaces


def test_continuous_actions_and_unknown_team_rewards_are_refused() -> None:
    class Continuous(UnevenGame):
        def action_space(self, agent: str) -> Any:
            return spaces.Box(0.0, 1.0, (1,))

    with pytest.raises(ConfigError, match="needs Discrete actions, got Box"):
        JointActionEnv(Continuous(masks_in="none"))
    with pytest.raises(UnknownNameError, match="did you mean 'mean'"):
        JointActionEnv(TwoStepGame(), team_reward="meann")


def seen(env: JointActionEnv) -> NDArray[Any]:
    return env.reset()[0]["obs"]


def test_agents_may_see_what_they_did_last() -> None:
    """Between what they see and who they are."""
    env = JointActionEnv(RepeatedGame(CLIMBING), last_action=True)
    obs, _ = env.reset()
    assert obs["obs"].tolist() == [[0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]

    obs, *_ = env.step(np.array([2, 0]))
    assert obs["obs"][:, 1:].tolist() == [[0, 0, 1, 1, 0], [1, 0, 0, 0, 1]]
    assert space_of(env).contains(obs)
    assert not env.reset()[0]["obs"][:, 1:4].any()


def test_resets_are_equal() -> None:
    env = JointActionEnv(TwoStepGame())

    assert (seen(env) == seen(env)).all()


def test_an_env_of_one_agent_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"takes a PettingZoo env .*; got TimeLimit"):
        JointActionEnv(gymnasium.make("CartPole-v1"))


class Late(Endless):
    """b comes with the second step, when a has gone; infos are missing, and nobody has a state."""

    metadata = {"name": "late_v0"}  # noqa: RUF012

    def state(self) -> NDArray[Any]:
        raise NotImplementedError  # as aec_to_parallel does where the game inside has none

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        self.agents, self.moment = ["a"], 0
        return {"a": np.ones(1, np.float32)}, {}

    def step(self, actions: dict[str, int]) -> tuple[Any, Any, Any, Any, Any]:
        assert list(actions) == self.agents
        self.moment += 1
        gone, self.agents = self.agents, ["b"] if self.moment == 1 else []
        seen = dict.fromkeys((*gone, *self.agents), np.ones(1, np.float32))
        return seen, dict.fromkeys(gone, 1.0), dict.fromkeys(gone, True), dict.fromkeys(gone, False), {}


def test_an_agent_that_has_not_come_yet_is_dead_until_it_comes() -> None:
    env = JointActionEnv(Late())
    assert "state" not in space_of(env).spaces
    obs, _ = env.reset()
    assert obs["alive"].tolist() == [1, 0]
    assert obs["obs"].tolist() == [[1, 1, 0], [0, 0, 1]]
    assert obs["action_mask"].tolist() == [[1, 1], [1, 0]]
    assert space_of(env).contains(obs)

    obs, reward, over, _, _ = env.step(np.array([1, 0]))
    assert (obs["alive"].tolist(), reward, over) == ([0, 1], 1.0, False)
    _, _, over, cut, _ = env.step(np.array([0, 1]))
    assert (over, cut) == (True, False)
    with pytest.raises(ConfigError, match="reset the env"):
        env.step(np.array([0, 0]))


def test_a_turn_based_game_without_a_state_is_taken() -> None:
    class TurnBased(Endless):
        metadata: dict[str, Any] = {"name": "turns_v0", "is_parallelizable": True}  # noqa: RUF012
        render_mode = None

    in_turns: Any = parallel_to_aec_wrapper(TurnBased())
    env = JointActionEnv(in_turns)
    assert "state" not in space_of(env).spaces
    assert space_of(env).contains(env.reset()[0])
    assert env.step(np.array([0, 1]))[1] == 1.0
    in_turns.metadata["is_parallelizable"] = False
    with pytest.raises(ConfigError, match="is_parallelizable"):
        JointActionEnv(in_turns)


BOX = spaces.Box(0.0, 1.0, (2,))


@pytest.mark.parametrize(
    "space",
    [
        spaces.Tuple((BOX, BOX)),
        spaces.Dict({"a": BOX, "b": BOX}),
        spaces.Dict({"observation": spaces.Dict({"a": BOX})}),
        spaces.Dict({"observation": spaces.Tuple((BOX,))}),
        spaces.Sequence(BOX),
        spaces.Text(5),
        spaces.Dict({"observation": BOX, "action_mask": spaces.Box(0, 1, (9,), np.int8)}),
    ],
)
def test_observations_that_are_no_single_array_are_refused_at_once(space: spaces.Space[Any]) -> None:
    class Other(Endless):
        def observation_space(self, agent: str) -> spaces.Space[Any]:
            return space

    with pytest.raises(ConfigError, match="agent 'a' has"):
        JointActionEnv(Other())


@pytest.mark.parametrize("space", [spaces.MultiBinary(2), spaces.MultiDiscrete([2, 2]), spaces.Tuple((BOX,))])
def test_actions_that_are_not_discrete_are_refused_at_once(space: spaces.Space[Any]) -> None:
    class Other(Endless):
        def action_space(self, agent: str) -> Any:
            return space

    with pytest.raises(ConfigError, match="needs Discrete actions"):
        JointActionEnv(Other())


@pytest.mark.parametrize("space", [spaces.Discrete(2), spaces.MultiBinary(1), spaces.MultiDiscrete([3])])
def test_observations_of_whole_numbers_are_taken(space: spaces.Space[Any]) -> None:
    class Other(Endless):
        def observation_space(self, agent: str) -> spaces.Space[Any]:
            return space

    env = JointActionEnv(Other())
    assert env.observation_space.contains(env.reset()[0])


def test_an_env_without_possible_agents_and_a_state_without_numbers_are_refused() -> None:
    class Nobody(Endless):
        possible_agents: list[str] = []  # noqa: RUF012

    class Wordy(Endless):
        def state(self) -> Any:
            return {"a": 1}

    with pytest.raises(ConfigError, match="possible_agents"):
        JointActionEnv(Nobody())
    with pytest.raises(ConfigError, match=r"env.state\(\) is no array of numbers"):
        JointActionEnv(Wordy())
    assert JointActionEnv(Wordy(), privileged_state=False).reset()


@pytest.mark.parametrize(
    "action",
    [[0.0, 1.9], [0, 2], [0, -1], [0], [0, 0, 0], [[0, 0]], None, ["0", "1"], [True, False], [0, [1]]],
)
def test_joint_actions_that_are_none_are_refused(action: Any) -> None:
    env = JointActionEnv(Endless())
    with pytest.raises(ConfigError, match="reset the env"):
        env.step(np.array([0, 0]))
    env.reset()
    with pytest.raises(
        ConfigError, match=r"actions must be whole numbers of shape \(2,\)|has the actions 0\.\.1"
    ):
        env.step(action)


def test_observations_and_masks_of_another_size_than_promised_are_told() -> None:
    class Grows(Endless):
        masks: Any = None

        def step(self, actions: dict[str, int]) -> tuple[Any, Any, Any, Any, Any]:
            seen, *rest, _ = super().step(actions)
            infos = {"a": {"action_mask": self.masks}} if self.masks is not None else {}
            return dict.fromkeys(seen, np.ones(1 if infos else 3, np.float32)), *rest, infos

    env = JointActionEnv(Grows())
    env.reset()
    with pytest.raises(ConfigError, match="agent 'a' observes 3 numbers, its space has 1"):
        env.step(np.array([0, 0]))
    Grows.masks = np.ones(5)
    env.reset()
    with pytest.raises(ConfigError, match=r"action_mask of agent 'a' has the shape \(5,\), expected \(2,\)"):
        env.step(np.array([0, 0]))
