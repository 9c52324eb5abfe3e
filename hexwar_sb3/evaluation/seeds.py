"""Which seeds serve which purpose, so that no reported game was ever trained or selected on.

A user's seed 0 .. SEEDS_PER_PURPOSE - 1 is shifted into the range of its purpose; docs/seeds.md
lists the ranges.
"""

from __future__ import annotations

from enum import IntEnum
from numbers import Integral

from hexwar_sb3.errors import ConfigError

SEEDS_PER_PURPOSE = 1_000_000


class Purpose(IntEnum):
    """What games are played for; the value is the number of the seed range."""

    TRAINING = 0
    SELECTION = 1  # evaluations during training that choose the best model
    REPORT = 2  # every figure that is printed or published
    TUNING = 3


def seed_for(purpose: Purpose, seed: object) -> int:
    """Shift a user's seed into the range of its purpose.

    Raises:
        ConfigError: the seed is not in 0..999999.

    Example:
        >>> seed_for(Purpose.REPORT, 7)
        2000007
    """
    if isinstance(seed, bool) or not isinstance(seed, Integral) or not 0 <= int(seed) < SEEDS_PER_PURPOSE:
        raise ConfigError(f"seed must be in 0..{SEEDS_PER_PURPOSE - 1}, got {seed!r}")
    return purpose * SEEDS_PER_PURPOSE + int(seed)
