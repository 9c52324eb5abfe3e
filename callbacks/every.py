"""Acts that repeat every so many env steps, between two vector steps."""

from __future__ import annotations

from abc import abstractmethod

from stable_baselines3.common.callbacks import BaseCallback

from hexwar_sb3.errors import ConfigError


class EverySteps(BaseCallback):
    """Fires when the number of env steps has passed a multiple of `every`, and at the end.

    Unlike `EveryNTimesteps` it needs no state of its own, so a resumed run fires where the unbroken
    run would, and it fires before a rollout, when everything collected is in the replay buffer.

    Args:
        every: env steps between two acts.
    """

    def __init__(self, every: int) -> None:
        super().__init__()
        if every < 1:
            raise ConfigError(f"steps between two acts must be at least 1, got {every}")
        self.every = every
        self._fired_at = 0

    def now(self) -> int:
        """Env steps so far."""
        return int(self.model.num_timesteps)

    @abstractmethod
    def fire(self) -> None:
        """Act."""

    def _on_training_start(self) -> None:
        self._fired_at = self.now()

    def _on_rollout_start(self) -> None:
        if self.now() // self.every > self._fired_at // self.every:
            self._fire()

    def _on_training_end(self) -> None:
        if self.now() > self._fired_at:
            self._fire()

    def _fire(self) -> None:
        self._fired_at = self.now()
        self.fire()

    def _on_step(self) -> bool:
        return True
