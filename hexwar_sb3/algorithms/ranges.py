"""Ranges of the algorithms' settings: a number out of range is refused before anything is built."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import Any

from hexwar_sb3.errors import ConfigError

_COUNT = (1.0, math.inf, "at least 1")
_SHARE = (0.0, 1.0, "in [0, 1]")
_POSITIVE = (math.ulp(0.0), sys.float_info.max, "above 0 and finite")
_RANGES = {
    "learning_rate": _POSITIVE,
    "final_learning_rate": _POSITIVE,
    "learning_rate_steps": _COUNT,
    "buffer_size": _COUNT,
    "batch_size": _COUNT,
    "tau": (math.ulp(0.0), 1.0, "in (0, 1]"),
    "gamma": _SHARE,
    "gradient_steps": _COUNT,
    "target_update_interval": _COUNT,
    "n_steps": _COUNT,
    "n_return_steps": _COUNT,
    "td_lambda": _SHARE,
    "reward_scale": _POSITIVE,
    "exploration_initial_eps": _SHARE,
    "exploration_final_eps": _SHARE,
    "exploration_episodes": _COUNT,
    "exploration_every": _COUNT,
    "exploration_steps": _COUNT,
    "update_every": _COUNT,
    "max_grad_norm": _POSITIVE,
    "chunk_size": _COUNT,
}


def check_ranges(settings: Mapping[str, Any]) -> None:
    """Check every setting that is there and a number; schedules and None are let through.

    Raises:
        ConfigError: a number is out of its range.
    """
    for name, (least, most, expected) in _RANGES.items():
        value = settings.get(name)
        if isinstance(value, int | float) and not least <= value <= most:
            raise ConfigError(f"{name} must be {expected}, got {value}")
