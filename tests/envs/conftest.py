"""Cheap stand-ins that the tests of the envs share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Masks = NDArray[Any]


def pick_valid(mask: Masks, step: int) -> NDArray[np.int64]:
    """A valid task for every piece that depends on its own mask and the step alone, [..., N]."""
    valid = mask.sum(-1)
    wanted = (7 * step + 3 * np.arange(mask.shape[-2])) % valid
    order = np.argsort(1 - mask, axis=-1, kind="stable")  # valid rows first
    return np.take_along_axis(order, wanted[..., None], -1)[..., 0]


@pytest.fixture
def pick() -> Callable[[Masks, int], NDArray[np.int64]]:
    return pick_valid
