"""What a study searches: settings by name, the values that each may take, and their place in a preset."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from typing import Any

from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)

from hexwar_sb3.algorithms.presets import Preset
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.tasks.spots import SPOTS

Point = dict[str, Any]  # setting -> value
Space = dict[str, BaseDistribution]

ALWAYS = ("alpha", "beta", "decision_ticks")
SPACE: Space = {
    "alpha": FloatDistribution(1e-3, 1.0, log=True),
    "beta": FloatDistribution(5e-3, 0.5, log=True),
    "decision_ticks": CategoricalDistribution((15, 25, 50, 75, 100, 150, 225, 300)),  # they divide a game
    "learning_rate": FloatDistribution(1e-4, 1e-2, log=True),
    "batch_size": CategoricalDistribution((32, 64, 128, 256)),
    "tau": FloatDistribution(1e-3, 1e-1, log=True),
    "spots": IntDistribution(2, 12),
    "td_lambda": CategoricalDistribution((None, 0.5, 0.8, 0.95)),  # None: n-step returns
    "mixer": CategoricalDistribution(("qmix", "vdn", "iql")),
    "hidden": CategoricalDistribution((32, 64, 128)),
}
"""All that can be searched; the names are those of the flags of `hexwar train` where it has them."""

PAPER: Point = {"alpha": 0.01, "beta": 0.05, "decision_ticks": 75}
"""The paper's point (IV)."""


def space_of(also: Iterable[str] = ()) -> Space:
    """Alpha, beta, Delta-t, and what else is asked for.

    Raises:
        UnknownNameError: there is no such setting.
    """
    also = tuple(also)
    for name in also:
        if name not in SPACE:
            raise UnknownNameError("setting", name, SPACE)
    return {name: SPACE[name] for name in dict.fromkeys((*ALWAYS, *also))}


def first_point(preset: Preset, space: Space) -> Point:
    """Where a study begins: the paper's point, and the preset's own value of every other setting.

    Raises:
        ConfigError: the space does not hold a value of the preset.
    """
    signature = inspect.signature(QMIX.__init__).parameters
    usual = {name: parameter.default for name, parameter in signature.items()}
    own = {**preset.env, **preset.learner, **preset.learner.get("policy_kwargs", {})}
    known = {**usual, "spots": SPOTS, "hidden": 64, **own, **PAPER}
    return checked_point({name: known[name] for name in space}, space)


def checked_point(point: object, space: Space) -> Point:
    """A point that somebody wants to be tried.

    Raises:
        ConfigError: it is not names and values, or a value is outside.
        UnknownNameError: a name is not searched.
    """
    if not isinstance(point, dict):
        raise ConfigError(f"a point is names and values, got {point!r}")
    for name, value in point.items():
        if name not in space:
            raise UnknownNameError("setting", str(name), space)
        if not _holds(space[name], value):
            raise ConfigError(f"{name} must be {_in_words(space[name])}, got {value!r}")
    return point


def short(value: object) -> str:
    """A value in three digits."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _in_words(distribution: BaseDistribution) -> str:
    if isinstance(distribution, CategoricalDistribution):
        return f"one of {', '.join(map(str, distribution.choices))}"
    kind = "a whole number" if isinstance(distribution, IntDistribution) else "a number"
    return f"{kind} in {distribution.low}..{distribution.high}"  # type: ignore[attr-defined]


def _holds(distribution: BaseDistribution, value: object) -> bool:
    if isinstance(distribution, CategoricalDistribution):
        return value in distribution.choices
    low, high = distribution.low, distribution.high  # type: ignore[attr-defined]
    kinds = int if isinstance(distribution, IntDistribution) else int | float
    return isinstance(value, kinds) and not isinstance(value, bool) and low <= value <= high
