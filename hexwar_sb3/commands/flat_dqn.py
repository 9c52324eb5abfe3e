"""`python -m hexwar_sb3.commands.flat_dqn`: the paper's baseline of Fig. 7.

SB3's own DQN on `HexWarFlat-v0`: a piece's task and direction are one action, and pieces decide in turn.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

from stable_baselines3 import DQN
from stable_baselines3.common.base_class import BaseAlgorithm

from hexwar_sb3.commands.baseline import Baseline, run_baseline
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import FLAT_ENV
from hexwar_sb3.rules.enums import Camp


@dataclass(frozen=True, kw_only=True)
class FlatDqn(Baseline):
    """Train the flat DQN for a number of games, then say what was learned."""

    title: ClassVar[str] = "the flat DQN"
    module: ClassVar[str] = "hexwar_sb3.commands.flat_dqn"
    algorithm: ClassVar[type[BaseAlgorithm]] = DQN
    env: ClassVar[str] = FLAT_ENV

    gamma: float = 0.99  # discount of a decision; a turn has its root by the number of pieces
    learning_rate: float = 5e-4
    buffer_size: int = 200_000  # turns; 0.7 GB
    learning_games: int = 16  # before the first update
    batch_size: int = 128
    gradient_steps: int = 1  # updates after a turn of every game
    target_update_turns: int = 16_000
    exploration_share: float = 0.4  # of the turns, in which epsilon falls to its last value
    exploration_initial_eps: float = 0.5
    exploration_final_eps: float = 0.05
    net_arch: tuple[int, ...] = (64, 64)  # SB3's own
    name: str = "flat_dqn"

    @property
    def env_settings(self) -> dict[str, Any]:
        """Half the memory."""
        return {"dtype": "float16"}

    def new_model(self) -> DQN:
        """SB3's own DQN with our settings."""
        return DQN(
            "MlpPolicy",
            self.make_env(),
            **self.learner,
            optimize_memory_usage=True,  # half the memory; games end by themselves, none is cut short
            replay_buffer_kwargs={"handle_timeout_termination": False},
        )

    @property
    def learner(self) -> dict[str, Any]:
        """Arguments of DQN."""
        return {
            "seed": self.seed,
            "device": "cpu",
            "gamma": self.gamma ** (1 / self.pieces),
            "learning_rate": self.learning_rate,
            "buffer_size": self.buffer_size,
            "learning_starts": self.learning_games * self.decisions * self.pieces,
            "batch_size": self.batch_size,
            "train_freq": 1,
            "gradient_steps": self.gradient_steps,
            "target_update_interval": self.target_update_turns,
            "exploration_fraction": self.exploration_share,
            "exploration_initial_eps": self.exploration_initial_eps,
            "exploration_final_eps": self.exploration_final_eps,
            "policy_kwargs": {"net_arch": list(self.net_arch)},
        }

    @property
    def pieces(self) -> int:
        """Pieces of a camp at the start: turns of a decision."""
        side = load_world(self.scenario).side(Camp.RED)
        return int(side.stop - side.start)

    @property
    def most_steps(self) -> int:
        """Turns that the games have if no piece dies."""
        return (self.games + self.n_envs) * self.decisions * self.pieces


if __name__ == "__main__":
    sys.exit(run_baseline(FlatDqn))
