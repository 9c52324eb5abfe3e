"""Checks of settings that several layers share."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real

import numpy as np

from hexwar_sb3.errors import ConfigError, UnknownNameError, shortened


def check_whole(setting: str, value: object, least: int, most: int | None = None) -> int:
    """Return a whole number.

    Raises:
        ConfigError: it is no integer, below `least` or above `most`.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise ConfigError(f"{setting} must be an integer >= {least}, got {shortened(repr(value))}")
    whole = int(value)
    if most is not None and whole > most:
        raise ConfigError(f"{setting} must be at most {most}, got {whole}")
    return whole


def check_choice(setting: str, value: object, choices: Iterable[str]) -> None:
    """Check a choice by name.

    Raises:
        UnknownNameError: it does not exist.
    """
    if not isinstance(value, str) or value not in choices:
        raise UnknownNameError(setting, str(value), choices)


def check_flag(setting: str, value: object) -> None:
    """Check a setting that is on or off.

    Raises:
        ConfigError: it is neither True nor False; a text such as "false" would count as True.
    """
    if not isinstance(value, bool | np.bool_):
        raise ConfigError(f"{setting} must be True or False, got {shortened(repr(value))}")


def check_number(setting: str, value: object) -> float:
    """Return a number.

    Raises:
        ConfigError: it is none.
    """
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise ConfigError(f"{setting} must be a number, got {shortened(repr(value))}")
    return float(value)


def check_share(setting: str, value: object) -> float:
    """Return a share of episodes.

    Raises:
        ConfigError: it is not in 0..1.
    """
    share = check_number(setting, value)
    if not 0.0 <= share <= 1.0:
        raise ConfigError(f"{setting} must be in 0..1, got {value!r}")
    return share
