"""Checks of settings that several layers share."""

from __future__ import annotations

from numbers import Integral

from hexwar_sb3.errors import ConfigError, shortened


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
