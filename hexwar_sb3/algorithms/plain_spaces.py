"""Observation spaces as plain values and back, for model zips that need no unpickling."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from hexwar_sb3.errors import ConfigError


def plain_boxes(space: spaces.Dict) -> dict[str, dict[str, Any]]:
    """Bounds and types of a Dict of Boxes, in its order.

    Raises:
        ConfigError: a part is no Box.
    """
    return {key: _plain_box(key, part) for key, part in space.items()}


def space_of_boxes(boxes: dict[str, dict[str, Any]]) -> spaces.Dict:
    """Make the space again."""
    return spaces.Dict([(key, _box(**plain)) for key, plain in boxes.items()])


def _plain_box(key: str, box: spaces.Space[Any]) -> dict[str, Any]:
    if not isinstance(box, spaces.Box):
        raise ConfigError(f"every part of the observation must be a Box, got {key!r}: {box}")
    return {"low": box.low.tolist(), "high": box.high.tolist(), "dtype": box.dtype.name}


def _box(low: Any, high: Any, dtype: str) -> spaces.Box:
    kind = np.dtype(dtype)
    return spaces.Box(np.array(low, kind), np.array(high, kind), dtype=kind.type)
