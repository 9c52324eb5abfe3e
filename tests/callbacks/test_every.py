from __future__ import annotations

import pytest
from stable_baselines3 import DQN

from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.errors import ConfigError


class Note(EverySteps):
    """Notes when it fires."""

    def __init__(self, every: int) -> None:
        super().__init__(every)
        self.fired: list[int] = []

    def fire(self) -> None:
        self.fired.append(self.num_timesteps)


def small_model() -> DQN:
    return DQN("MlpPolicy", "CartPole-v1", train_freq=4, learning_starts=1_000, seed=0)


def test_it_fires_when_a_multiple_has_passed_and_at_the_end() -> None:
    """Rollouts of 4 steps: the multiples of 30 have passed at 32, 60 and 92."""
    note = Note(30)

    small_model().learn(100, callback=note)

    assert note.fired == [32, 60, 92, 100]


def test_a_resumed_run_fires_where_the_unbroken_one_does() -> None:
    model, first, second = small_model(), Note(30), Note(30)

    model.learn(60, callback=first)
    model.learn(40, callback=second, reset_num_timesteps=False)

    assert first.fired + second.fired == [32, 60, 92, 100]


def test_a_step_count_of_zero_is_refused() -> None:
    with pytest.raises(ConfigError, match="at least 1, got 0"):
        Note(0)
