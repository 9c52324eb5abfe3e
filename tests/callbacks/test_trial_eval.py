"""Evaluations that a study hears of, with any model of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import gymnasium
import optuna
import pytest
from stable_baselines3 import A2C, DQN, PPO
from stable_baselines3.common.monitor import Monitor

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.trial_eval import TrialEvalCallback
from hexwar_sb3.envs.registration import make_vec_env


class Listener:
    """A trial that writes down what it hears, and prunes after so many reports."""

    def __init__(self, last: int | None = None) -> None:
        self.heard: list[tuple[int, float]] = []
        self.last = last

    def report(self, value: float, step: int) -> None:
        self.heard.append((step, value))

    def should_prune(self) -> bool:
        return len(self.heard) == self.last


@pytest.mark.parametrize(
    ("kind", "steps"), [(PPO, {"n_steps": 50, "batch_size": 50}), (A2C, {"n_steps": 50}), (DQN, {})]
)
def test_every_evaluation_is_reported(kind: type[Any], steps: dict[str, int]) -> None:
    trial = Listener()
    callback = TrialEvalCallback(
        Monitor(gymnasium.make("CartPole-v1")), trial, eval_freq=100, n_eval_episodes=1
    )
    kind("MlpPolicy", "CartPole-v1", seed=0, **steps).learn(300, callback=callback)

    assert [step for step, _ in trial.heard] == [100, 200, 300]
    assert trial.heard[-1][1] == callback.last_mean_reward
    assert not callback.is_pruned


def test_a_pruned_trial_ends_the_training() -> None:
    trial = Listener(last=2)
    callback = TrialEvalCallback(
        Monitor(gymnasium.make("CartPole-v1")), trial, eval_freq=100, n_eval_episodes=1
    )
    model = DQN("MlpPolicy", "CartPole-v1", seed=0).learn(1_000, callback=callback)

    assert callback.is_pruned
    assert model.num_timesteps == 200


def test_a_study_of_ones_own_with_qmix() -> None:
    """Without a pruner both evaluations are heard; one that prunes at once ends the training at the first."""

    def objective(trial: optuna.Trial) -> float:
        steps = trial.suggest_int("steps", 1, 3)
        callback = TrialEvalCallback(
            make_vec_env(seed=1, reward="net"), trial, eval_freq=12, n_eval_episodes=1
        )
        model = QMIX("TaskPolicy", make_vec_env(n_envs=2, reward="net", seed=0), n_steps=steps, seed=0)
        model.learn(48, callback=callback)
        if callback.is_pruned:
            raise optuna.TrialPruned
        return callback.last_mean_reward

    always = optuna.pruners.ThresholdPruner(lower=1e9)
    for pruner, state in ((None, optuna.trial.TrialState.COMPLETE), (always, optuna.trial.TrialState.PRUNED)):
        study = optuna.create_study(direction="maximize", pruner=pruner or optuna.pruners.NopPruner())
        study.optimize(objective, n_trials=1)
        assert study.trials[0].state == state
        assert len(study.trials[0].intermediate_values) == (1 if pruner else 2)
