"""Hot spots G^L: control points and k more cells that tasks lead to."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.world import World

SPOTS = 6  # cells beside the control points


def load_spots(world: World, k: int = SPOTS) -> np.ndarray:
    """Cells of G^L for both camps: i2 [2, S], S = control points + k, in the order of each camp's frame."""
    raise NotImplementedError
