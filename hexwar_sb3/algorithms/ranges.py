"""Kinds and ranges of settings and counters: one table for construction, saving and loading.

A kind takes a value as a user may give it (numpy's numbers, 16.0 for 16, a Path for a text) and gives the plain one, so
that what was made can also be saved and loaded. It raises `Misfit` where there is none.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from hexwar_sb3.errors import ConfigError, UnknownNameError, UnknownSettingError, shortened

Kind: TypeAlias = Callable[[Any], Any]
Table: TypeAlias = Mapping[str, Kind]
MOST_COUNT = 10**15  # of env steps, updates and so on
MOST_TICKS = 10**12
MOST_STEPS = 10**7  # of a replay
MOST_BATCH = 1 << 20
MOST_WIDTH = 4_096  # of a layer
MOST_LAYERS = 16
MOST_LISTED = 1_000  # opponents, scenarios
INFINITE = "inf"  # in a file: JSON has no word for it


class Misfit(Exception):  # noqa: N818  # it becomes an error of the place where the value came from
    """A value that is none of its kind: where, what it is, what it should be."""

    def __init__(self, found: object, expected: str, place: str = "") -> None:
        super().__init__(expected)
        self.found, self.expected, self.place = shortened(repr(found)), expected, place

    def within(self, name: str) -> Misfit:
        """The same, of a part of something larger."""
        self.place = f"{name}.{self.place}" if self.place else name
        return self

    def as_setting(self) -> ConfigError:
        """The error of who gave it."""
        return ConfigError(f"{self.place} must be {self.expected}, got {self.found}")


def scalar(value: Any) -> Any:
    """The plain value that one of numpy, a path or a text stands for; anything else as it is."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return value.item()
    return str(value) if isinstance(value, str | Path) else value


def row(value: Any) -> Any:
    """A list of an array; anything else as it is."""
    return value.tolist() if isinstance(value, np.ndarray) and value.ndim else scalar(value)


def plain(value: Any) -> Any:
    """The same within lists and dicts."""
    found = row(value)
    if type(found) in (list, tuple):
        return type(found)(plain(one) for one in found)
    if isinstance(found, dict):
        return {scalar(name): plain(one) for name, one in found.items()}
    return found


def is_plain(value: Any) -> bool:
    """Whether JSON keeps a value as it is (a tuple as a list, an infinite number as `INFINITE`)."""
    if isinstance(value, dict):
        return all(type(name) is str and is_plain(one) for name, one in value.items())
    if isinstance(value, list | tuple):
        return all(is_plain(one) for one in value)
    return (
        value is None or type(value) in (bool, int, str) or (type(value) is float and not math.isnan(value))
    )


@dataclass(frozen=True)
class Number:
    """A number in a range."""

    least: float
    most: float
    expected: str

    def __call__(self, value: Any) -> float:
        """Give it as a float."""
        found = scalar(value)
        if isinstance(found, bool) or not isinstance(found, Real):
            raise Misfit(value, self.expected)
        try:
            number = float(found)
        except OverflowError:
            number = math.inf
        if not self.least <= number <= self.most:
            raise Misfit(value, self.expected)
        return number


@dataclass(frozen=True)
class Whole:
    """A whole number in a range; 16.0 counts as one."""

    least: int = 1
    most: int = MOST_COUNT

    def __call__(self, value: Any) -> int:
        """Give it as an int."""
        found = scalar(value)
        is_whole = isinstance(found, Integral) or (isinstance(found, float) and found.is_integer())
        if isinstance(found, bool) or not is_whole:
            raise Misfit(value, f"a whole number of at least {self.least}")
        if found < self.least:
            raise Misfit(value, f"at least {self.least}")
        if found > self.most:
            raise Misfit(value, f"at most {self.most}")
        return int(found)


@dataclass(frozen=True)
class Choice:
    """One of some words; `what` is chosen in a word."""

    what: str
    names: Iterable[str]

    def __call__(self, value: Any) -> str:
        """Give the word.

        Raises:
            UnknownNameError: there is none like it.
        """
        found = scalar(value)
        if not isinstance(found, str) or found not in tuple(self.names):
            raise UnknownNameError(self.what, found if isinstance(found, str) else repr(found), self.names)
        return found


@dataclass(frozen=True)
class Parts:
    """A dict of parts, each of its own kind.

    What is not in the table is refused, but for `others`: they may be anything, as classes and functions are, which no
    file holds.
    """

    table: Table
    others: tuple[str, ...] = ()

    def __call__(self, value: Any) -> dict[str, Any]:
        """Give a copy with plain values.

        Raises:
            UnknownSettingError: there is no such part.
        """
        if not isinstance(value, Mapping):
            raise Misfit(value, "names and values")
        for name in value:
            if name not in self.table and name not in self.others:
                raise UnknownSettingError("setting", str(name), [*self.table, *self.others])
        return {
            name: mended(name, one, self.table[name]) if name in self.table else one
            for name, one in value.items()
        }


def mended(name: str, value: Any, kind: Kind) -> Any:
    """The plain value of a setting.

    Raises:
        Misfit: it is none of its kind.
    """
    try:
        return kind(value)
    except Misfit as misfit:
        raise misfit.within(name) from None


def setting(name: str, value: Any, kind: Kind) -> Any:
    """The plain value of a setting that a user gave.

    Raises:
        ConfigError: it is none of its kind, or out of its range.
    """
    try:
        return mended(name, value, kind)
    except Misfit as misfit:
        raise misfit.as_setting() from None


def check_settings(values: Mapping[str, Any], table: Table) -> None:
    """Check settings by their table; what is not in it is let through.

    Raises:
        ConfigError: one is of another kind, or out of its range.
    """
    for name in values.keys() & table.keys():
        setting(name, values[name], table[name])


def optional(kind: Kind) -> Kind:
    """None, or of a kind."""
    return lambda value: None if value is None else kind(value)


def flag(value: Any) -> bool:
    """True or False."""
    found = scalar(value)
    if type(found) is not bool:
        raise Misfit(value, "True or False")
    return found


def text(value: Any) -> str:
    """Some text."""
    found = scalar(value)
    if not isinstance(found, str):
        raise Misfit(value, "a word")
    return found


def options(value: Any) -> dict[str, Any]:
    """Arguments of a class of one's own, plain where they can be."""
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise Misfit(value, "names and values")
    return {name: plain(one) for name, one in value.items()}


def anything(value: Any) -> Any:
    """A name, an object, or a list of them, each perhaps with a weight; from a file that is texts and numbers."""
    found = row(value)
    if isinstance(found, list | tuple):
        if len(found) > MOST_LISTED or any(isinstance(one, list | tuple) and len(one) != 2 for one in found):
            raise Misfit(value, f"a name, or a list of at most {MOST_LISTED} names")
        found = type(found)(
            tuple(map(scalar, one)) if isinstance(one, list | tuple) else scalar(one) for one in found
        )
    if isinstance(found, dict):
        raise Misfit(value, "a name, or a list of names")
    return found


def rate(value: Any) -> Any:
    """A learning rate: a number, or a function of SB3's progress. 0 is for play alone, as rl-zoo loads models."""
    return value if callable(value) else Number(0.0, sys.float_info.max, "above 0 and finite")(value)


def unlimited(value: Any) -> float:
    """A number above 0 that may be infinite."""
    return POSITIVE_OR_INFINITE(math.inf if value == INFINITE else value)


def row_of(kind: Kind, most: int) -> Kind:
    """A list of values of a kind, no longer than `most`."""

    def mend(value: Any) -> list[Any]:
        found = row(value)
        if not isinstance(found, list | tuple) or len(found) > most:
            raise Misfit(value, f"a list of at most {most}")
        return [kind(one) for one in found]

    return mend


def pair(first: Kind, second: Kind, expected: str) -> Kind:
    """Two values, as a tuple."""

    def mend(value: Any) -> tuple[Any, Any]:
        found = row(value)
        try:
            one, other = found
            return first(one), second(other)
        except (Misfit, TypeError, ValueError):
            raise Misfit(value, expected) from None

    return mend


COUNTER = Whole(0)
SHARE = Number(0.0, 1.0, "in [0, 1]")
POSITIVE = Number(math.ulp(0.0), sys.float_info.max, "above 0 and finite")
POSITIVE_OR_INFINITE = Number(math.ulp(0.0), math.inf, "above 0")
NOT_NEGATIVE = Number(0.0, sys.float_info.max, "finite and at least 0")
WIDTH = Whole(1, MOST_WIDTH)
SEED = optional(Whole(0, (1 << 32) - 1))  # numpy's global generator takes no other

OPTIMIZER = Parts(
    {
        "eps": POSITIVE,
        "betas": pair(SHARE, SHARE, "two numbers in [0, 1]"),
        "weight_decay": NOT_NEGATIVE,
        "momentum": NOT_NEGATIVE,
        "amsgrad": flag,
        "fused": optional(flag),
        "foreach": optional(flag),
    }
)
"""Arguments of torch's optimisers that a file may hold."""

LEARNING: Table = {
    "learning_rate": rate,
    "final_learning_rate": optional(POSITIVE),
    "buffer_size": Whole(1, MOST_STEPS),
    "learning_starts": Whole(0),
    "batch_size": Whole(1, MOST_BATCH),
    "tau": Number(math.ulp(0.0), 1.0, "in (0, 1]"),
    "gamma": SHARE,
    "gradient_steps": Whole(1, MOST_BATCH),
    "target_update_interval": Whole(),
    "n_steps": Whole(1, 10_000),
    "exploration_initial_eps": SHARE,
    "exploration_final_eps": SHARE,
    "max_grad_norm": POSITIVE,
    "stats_window_size": Whole(1, 1_000_000),
    "seed": SEED,
}
"""Settings that all algorithms have."""

COUNTERS: Table = dict.fromkeys(("num_timesteps", "_episode_num", "_n_updates"), COUNTER)
"""Counters that all algorithms have."""
