"""`python -m hexwar_sb3.commands.task_ppo`: MaskablePPO of sb3-contrib on the task env, a baseline of the upper level."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

from sb3_contrib import MaskablePPO
from stable_baselines3.common.base_class import BaseAlgorithm

from hexwar_sb3.commands.baseline import Baseline, run_baseline
from hexwar_sb3.envs.registration import TASK_ENV


@dataclass(frozen=True, kw_only=True)
class TaskPpo(Baseline):
    """Train MaskablePPO to give tasks, led by the heuristic, then say what was learned."""

    title: ClassVar[str] = "MaskablePPO"
    module: ClassVar[str] = "hexwar_sb3.commands.task_ppo"
    algorithm: ClassVar[type[BaseAlgorithm]] = MaskablePPO
    env: ClassVar[str] = TASK_ENV

    gamma: float = 0.99  # discount of a decision
    learning_rate: float = 3e-4
    n_steps: int = 96  # of each game between two rounds of updates: four games
    batch_size: int = 256
    n_epochs: int = 4
    ent_coef: float = 0.01
    gae_lambda: float = 0.95
    net_arch: tuple[int, ...] = (64, 64)  # SB3's own
    name: str = "task_ppo"

    def new_model(self) -> MaskablePPO:
        """MaskablePPO with our settings, else its own."""
        how: dict[str, Any] = {
            name: getattr(self, name)
            for name in ("seed", "gamma", "learning_rate", "n_steps", "batch_size", "n_epochs", "ent_coef")
        }
        how |= {"gae_lambda": self.gae_lambda, "policy_kwargs": {"net_arch": list(self.net_arch)}}
        return MaskablePPO("MultiInputPolicy", self.make_env(), device="cpu", **how)

    @property
    def most_steps(self) -> int:
        """Decisions of the games."""
        return (self.games + self.n_envs) * self.decisions


if __name__ == "__main__":
    sys.exit(run_baseline(TaskPpo))
