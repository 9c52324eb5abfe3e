"""`python -m hexwar_sb3.commands.rival_dqn`: the flat DQN of Fig. 7 with all that the hierarchy has.

Masked values, exploration that sticks, demonstrations and n-step returns; `hexwar experiments rivals` compares settings.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray
from stable_baselines3 import DQN
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import NStepReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.type_aliases import PyTorchObs
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import Tensor

from hexwar_sb3.algorithms.exploration import Explorer
from hexwar_sb3.callbacks.shares import ShareOfGames
from hexwar_sb3.commands.baseline import run_baseline
from hexwar_sb3.commands.flat_dqn import FlatDqn
from hexwar_sb3.envs.flat_games import FlatGames
from hexwar_sb3.evaluation.opponents import with_weights
from hexwar_sb3.policies.masked import fill_masked
from hexwar_sb3.tasks.features import sizes
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.route import N_ANSWERS


class RivalQNetwork(QNetwork):
    """Q of every task and answer [B, K * 7]; rows of zeros in the observation are no tasks."""

    def forward(self, obs: PyTorchObs) -> Float[Tensor, "batch action"]:
        """Value the actions whose task is valid."""
        width = sizes(1, 1, 1).row
        rows = cast("Tensor", obs)[:, -MAX_TASKS * width :].reshape(-1, MAX_TASKS, width)
        valid = (rows != 0).any(dim=2).repeat_interleave(N_ANSWERS, dim=1)
        return fill_masked(super().forward(obs), valid.float())


class RivalPolicy(DQNPolicy):
    """DQN's policy over valid tasks."""

    def make_q_net(self) -> QNetwork:
        """Make a network with a features extractor of its own."""
        arguments = self._update_features_extractor(self.net_args, features_extractor=None)
        return RivalQNetwork(**arguments).to(self.device)


class RivalDQN(DQN):
    """SB3's DQN that explores among legal actions, sticks to what it explores, and learns from demonstrations."""

    stickiness = 0.0  # probability that an exploring piece keeps its random action at its next turn

    def _setup_model(self) -> None:
        super()._setup_model()
        self.rng = np.random.default_rng(self.seed)
        self.exploring: NDArray[np.bool_] | None = None  # [game, piece]

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Pick the best action of every piece whose turn it is, or let it explore."""
        games = self._games()
        if self.exploring is None:
            self.exploring = np.zeros(games.picked.shape, np.bool_)
        greedy, _ = self.policy.predict(cast("NDArray[Any]", self._last_obs), deterministic=True)
        epsilon = 1.0 if self.num_timesteps < learning_starts else self.exploration_rate
        explorer = Explorer(n_envs, 1, self.stickiness)
        explorer.exploring[:, 0] = self.exploring[games.all, games.acting]
        under_way, masks = games.under_way()[:, None], games.masks()[:, None]
        actions = explorer.choose(greedy[:, None], under_way, masks, epsilon, self.rng)[:, 0]
        self.exploring[games.all, games.acting] = explorer.exploring[:, 0]
        return actions, actions

    def _store_transition(self, replay_buffer: Any, buffer_action: Any, *args: Any) -> None:
        """Store what was done: by a bot, in a demonstration."""
        *_, dones, infos = args
        cast("NDArray[np.bool_]", self.exploring)[dones] = False
        done = np.array([info.get("demo_actions", buffer_action[b]) for b, info in enumerate(infos)])
        super()._store_transition(replay_buffer, done, *args)

    def _games(self) -> FlatGames:
        return cast("FlatGames", cast("Any", self.env).get_attr("games")[0])


@dataclass(frozen=True, kw_only=True)
class RivalDqn(FlatDqn):
    """Train the flat DQN with all that the hierarchy has, then say what was learned."""

    title: ClassVar[str] = "the flat DQN with the means of the hierarchy"
    module: ClassVar[str] = "hexwar_sb3.commands.rival_dqn"
    algorithm: ClassVar[type[BaseAlgorithm]] = RivalDQN

    buffer_size: int = 100_000  # turns; 0.7 GB
    n_steps: int = 28  # turns of a transition: four decisions
    tau: float = 1.0  # share of the network that goes into the target
    stickiness: float = 0.8
    demo: tuple[str, ...] = ("MA2",)  # bots, replays (*.hwr), or folders of them
    demo_share: float = (
        0.25  # of the first games: one of these plays the learner's seat, and the learner watches
    )
    demo_games: int = 500
    name: str = "rival_dqn"

    @property
    def env_settings(self) -> dict[str, Any]:
        """Somebody for the demonstrations."""
        demo = list(with_weights(self.demo, "demonstration").items())
        return {**super().env_settings, "demo": demo}

    def new_model(self) -> RivalDQN:
        """SB3's DQN with our settings and additions."""
        learner = self.learner
        learner["policy_kwargs"] = {**learner["policy_kwargs"], "optimizer_kwargs": {"fused": True}}
        model = RivalDQN(
            RivalPolicy,
            self.make_env(),
            **learner,
            tau=self.tau,
            replay_buffer_class=NStepReplayBuffer,
            replay_buffer_kwargs={"n_steps": self.n_steps, "gamma": learner["gamma"]},
        )
        model.stickiness = self.stickiness
        return model

    def watchers(self) -> list[BaseCallback]:
        """Demonstrations at first."""
        return [
            ShareOfGames(
                "set_demo_share", lambda played: self.demo_share if played < self.demo_games else 0.0
            )
        ]


if __name__ == "__main__":
    sys.exit(run_baseline(RivalDqn))
