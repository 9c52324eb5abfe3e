"""Distillation before a model learns on: it takes over what its teachers do."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import cast

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.league.distil import Lessons, distill
from hexwar_sb3.players.frozen import FrozenPolicy


class DistillationCallback(BaseCallback):
    """Lets the model learn from several policies when `learn` begins; then it learns on by itself.

    The teachers play the games of the model's env settings: its side, opponents and scenario.

    Args:
        teachers: policies of any widths, or their folders.
        lessons: how the model is taught.
        refit_games: games in which the mixer alone learns after it, so that the model's values fit its new choices.

    Example:
        >>> from hexwar_sb3.league import Lessons
        >>> from hexwar_sb3.players import make_player
        >>> model = QMIX("TaskPolicy", make_vec_env(side="both", privileged_state=True), seed=0)
        >>> teach = DistillationCallback([make_player("HRL0")], Lessons(games=1, updates=1))
        >>> _ = model.learn(24, callback=teach)
    """

    def __init__(
        self,
        teachers: Sequence[FrozenPolicy | str | Path],
        lessons: Lessons | None = None,
        *,
        refit_games: int = 200,
    ) -> None:
        super().__init__()
        self.teachers = [one if isinstance(one, FrozenPolicy) else FrozenPolicy.load(one) for one in teachers]
        self.lessons, self.refit_games = lessons or Lessons(), refit_games
        self.losses: list[float] = []
        self._mixer_games_left = 0

    def _on_training_start(self) -> None:
        model = self.model
        if not isinstance(model, QMIX):
            raise ConfigError(f"the student is a QMIX or HierarchicalQMIX, got {type(model).__name__}")
        env = cast("VecEnv", model.get_env())
        settings = cast("TaskSettings", env.get_attr("games")[0].settings)
        self.losses = distill(
            self.teachers, model, {**vars(settings), "n_envs": env.num_envs}, self.lessons, model.seed or 0
        )
        self.logger.record("distillation/loss", self.losses[-1])
        self._mixer_games_left = self.refit_games

    def _freeze_agent(self, frozen: bool) -> None:
        cast("QMIX", self.model).policy.agent.requires_grad_(not frozen)

    def _on_rollout_start(self) -> None:
        self._freeze_agent(self._mixer_games_left > 0)

    def _on_step(self) -> bool:
        self._mixer_games_left -= int(sum(self.locals["dones"]))
        return True

    def _on_training_end(self) -> None:
        self._freeze_agent(False)
