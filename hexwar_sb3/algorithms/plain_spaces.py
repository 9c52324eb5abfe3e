"""Observation spaces as plain values and back, for model zips that need no unpickling."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.algorithms.ranges import INFINITE, Choice, Misfit, Parts, Whole, mended, row_of
from hexwar_sb3.errors import ConfigError

MOST_NUMBERS = 1 << 22  # of an observation
MOST_PARTS = 64
MOST_BOUNDS = 40_000  # that are written down, where they differ within a part
DTYPES = ("float16", "float32", "float64", "bool", "int8", "int16", "int32", "int64", "uint8", "uint16")


def plain_boxes(space: spaces.Dict) -> dict[str, dict[str, Any]]:
    """Bounds and types of a Dict of Boxes, in its order.

    Raises:
        ConfigError: a part is no Box, or it is larger than a model can be.
    """
    if sum(prod(part.shape or ()) for part in space.values()) > MOST_NUMBERS or len(space) > MOST_PARTS:
        raise ConfigError(
            f"an observation has at most {MOST_NUMBERS} numbers in {MOST_PARTS} parts, got {space}"
        )
    made = {key: _plain_box(key, part) for key, part in space.items()}
    if sum(len(box["low"]) + len(box["high"]) for box in made.values()) > MOST_BOUNDS:
        raise ConfigError(f"the parts of an observation have at most {MOST_BOUNDS} different bounds")
    return made


def boxes(value: Any) -> dict[str, Any]:
    """Plain values of boxes, as a kind of what a file holds."""
    if not isinstance(value, Mapping) or not 1 <= len(value) <= MOST_PARTS:
        raise Misfit(value, f"1 to {MOST_PARTS} boxes")
    checked = {name: mended(name, box, _BOX) for name, box in value.items()}
    for name, box in checked.items():
        if set(box) != set(_BOX.table):
            raise Misfit(sorted(box), f"{sorted(_BOX.table)}", name)
    if sum(prod(box["shape"]) for box in checked.values()) > MOST_NUMBERS:
        raise Misfit("more", f"at most {MOST_NUMBERS} numbers")
    return checked


def space_of_boxes(plain: dict[str, dict[str, Any]]) -> spaces.Dict:
    """Make the space again.

    Raises:
        Misfit: bounds and shape do not fit together.
    """
    try:
        return spaces.Dict([(key, _box(**box)) for key, box in plain.items()])
    except (ValueError, TypeError, OverflowError, AssertionError) as error:
        raise Misfit(str(error), "bounds of boxes") from error


def _plain_box(key: str, box: spaces.Space[Any]) -> dict[str, Any]:
    if not isinstance(box, spaces.Box):
        raise ConfigError(f"every part of the observation must be a Box, got {key!r}: {box}")
    bounds = {"low": _plain_bound(box.low), "high": _plain_bound(box.high)}
    return {"shape": list(box.shape), **bounds, "dtype": box.dtype.name}


def _plain_bound(bound: NDArray[Any]) -> list[Any]:
    """One number if all are equal, else all of them."""
    flat = bound.ravel()
    some = flat[:1] if flat.size and (flat == flat[0]).all() else flat
    return list(some.tolist())


def _bound(value: Any) -> Any:
    if type(value) in (int, float, bool):
        return value
    if value not in (INFINITE, f"-{INFINITE}"):
        raise Misfit(value, "a number")
    return float(value)


_BOX = Parts(
    {
        "shape": row_of(Whole(0, MOST_NUMBERS), 8),
        "low": row_of(_bound, MOST_BOUNDS),
        "high": row_of(_bound, MOST_BOUNDS),
        "dtype": Choice("type of numbers", DTYPES),
    }
)


def _box(shape: list[int], low: list[Any], high: list[Any], dtype: str) -> spaces.Box:
    kind = np.dtype(dtype)
    ends = [
        np.full(shape, end[0], kind) if len(end) == 1 else np.array(end, kind).reshape(shape)
        for end in (low, high)
    ]
    if not (ends[0] <= ends[1]).all():
        raise ValueError("a low bound above the high one")
    return spaces.Box(ends[0], ends[1], dtype=kind.type)
