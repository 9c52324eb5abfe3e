"""The progress bar of a training: env steps, win rate, games a second."""

from __future__ import annotations

from time import monotonic
from typing import cast

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor
from tqdm import tqdm


class ProgressBar(BaseCallback):
    """Shows how far the training is, the win rate of the last 100 training games, and games a second.

    The env is a `VecMonitor` with the info keyword "win".

    Args:
        total_timesteps: env steps of the whole training.
    """

    def __init__(self, total_timesteps: int) -> None:
        super().__init__()
        self.total_timesteps = total_timesteps
        self._started = 0.0

    def _on_training_start(self) -> None:
        self._started = monotonic()
        done = self.model.num_timesteps
        self._bar = tqdm(total=self.total_timesteps, initial=done, unit="step", dynamic_ncols=True)

    def _on_step(self) -> bool:
        self._bar.set_postfix_str(self._text(), refresh=False)
        self._bar.update(self.training_env.num_envs)
        return True

    def _on_training_end(self) -> None:
        self._bar.close()

    def _text(self) -> str:
        recent = [game["win"] for game in self.model.ep_info_buffer or () if "win" in game]
        won = f"{sum(recent) / len(recent):.0%}" if recent else "-"
        games = cast("VecMonitor", self.training_env).episode_count
        return f"wins {won}, {games / max(monotonic() - self._started, 1e-9):.1f} games/s"
