"""Evaluations that an Optuna study hears of, for any model of Stable-Baselines3."""

from __future__ import annotations

from typing import Any, Protocol

from stable_baselines3.common.callbacks import EvalCallback


class Reports(Protocol):
    """What an `optuna.Trial` does for pruning."""

    def report(self, value: float, step: int) -> None:
        """Take what was reached after so many steps."""

    def should_prune(self) -> bool:
        """Whether it is not worth going on."""


class TrialEvalCallback(EvalCallback):
    """`EvalCallback` that reports each mean return to a trial, and stops the training if the study prunes it.

    Raise `optuna.TrialPruned` after `learn` if `is_pruned`, so that the study knows.

    Args:
        eval_env: as in `EvalCallback`.
        trial: the trial of your objective.
        kwargs: further arguments of `EvalCallback`: n_eval_episodes, eval_freq (calls, each of which steps all envs), ...

    Example:
        >>> import optuna
        >>> def objective(trial):
        ...     model = QMIX("TaskPolicy", make_vec_env(), gamma=trial.suggest_float("gamma", 0.9, 1.0))
        ...     callback = TrialEvalCallback(make_vec_env(), trial, eval_freq=24, n_eval_episodes=1)
        ...     model.learn(24, callback=callback)
        ...     if callback.is_pruned:
        ...         raise optuna.TrialPruned
        ...     return callback.last_mean_reward
        >>> optuna.create_study(direction="maximize").optimize(objective, n_trials=1)
    """

    def __init__(self, eval_env: Any, trial: Reports, **kwargs: Any) -> None:
        super().__init__(eval_env, **{"verbose": 0, **kwargs})
        self.trial, self.is_pruned = trial, False

    def _on_step(self) -> bool:
        goes_on = super()._on_step()
        if self.eval_freq > 0 and self.n_calls % self.eval_freq == 0:  # it has just evaluated
            self.trial.report(self.last_mean_reward, self.num_timesteps)
            self.is_pruned = self.trial.should_prune()
        return goes_on and not self.is_pruned
