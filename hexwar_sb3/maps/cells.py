"""One record a cell: what kernels read of a map."""

from __future__ import annotations

import numpy as np

NO_HOP = 0  # hop_ticks: no way there
NO_CELL = -1  # off the map or void

CELL = np.dtype(
    [
        ("neighbour", "i2", (6,)),  # W SW SE E NE NW; NO_CELL (-1): off the map or void
        ("hop_ticks", "i2", (2, 6)),  # [HopClass, direction]; NO_HOP: none
        ("mirror", "i2"),  # the mirror map of section 1
        ("x", "i2"),
        ("y", "i2"),
        ("q", "i2"),  # cube coordinates
        ("r", "i2"),
        ("elev_m", "i2"),
        ("level", "i2"),  # elev_m / grade
        ("exposure", "f4"),  # share of the playable cells within 15 that see it, 0..1
        ("playable", "u1"),
        ("controllable", "u1"),
        ("passable", "u1"),
        ("paved", "u1"),
        ("concealed", "u1"),
        ("slushy", "u1"),
    ],
    align=True,
)
