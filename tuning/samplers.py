"""Samplers by name: one that goes on with a study draws what an unbroken one would."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from optuna import Study
from optuna.distributions import BaseDistribution
from optuna.exceptions import ExperimentalWarning
from optuna.samplers import BaseSampler, GPSampler, QMCSampler, RandomSampler, TPESampler
from optuna.trial import FrozenTrial

from hexwar_sb3.tuning.workers import AGAIN

SAMPLERS: dict[str, Callable[[int], BaseSampler]] = {
    "tpe": lambda seed: TPESampler(seed=seed, multivariate=True, constant_liar=True),
    "gp": lambda seed: GPSampler(seed=seed),
    "random": lambda seed: RandomSampler(seed=seed),
    "qmc": lambda seed: QMCSampler(seed=seed),
}
"""By a seed."""
STRIDE = 1_000_003  # between the seeds of two studies' trials


def make_sampler(name: str, seed: int) -> BaseSampler:
    """Sampler that draws each trial by a seed of its own, made of the study's and the trial's place.

    Trials that came again, their points known, have no place: a study whose process was killed draws on as an unbroken
    one.
    """
    return _SamplerOfTrial(SAMPLERS[name], seed)


class _SamplerOfTrial(BaseSampler):
    def __init__(self, make: Callable[[int], BaseSampler], seed: int) -> None:
        self._make, self._seed = make, seed

    def before_trial(self, study: Study, trial: FrozenTrial) -> None:
        earlier = study.get_trials(deepcopy=False)[: trial.number]
        place = trial.number - sum(AGAIN in one.user_attrs for one in earlier)
        with warnings.catch_warnings(action="ignore", category=ExperimentalWarning):
            self._own = self._make((self._seed * STRIDE + place) % 2**32)
        self._own.before_trial(study, trial)

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        return self._own.infer_relative_search_space(study, trial)

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        return self._own.sample_relative(study, trial, search_space)

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        return self._own.sample_independent(study, trial, param_name, param_distribution)

    def after_trial(self, study: Study, trial: FrozenTrial, state: Any, values: Any) -> None:
        self._own.after_trial(study, trial, state, values)
