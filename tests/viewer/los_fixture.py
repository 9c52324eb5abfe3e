"""Lines of sight as the engine has them, for the one rule that the page computes itself.

`python tests/viewer/los_fixture.py` writes viewer/test/los.json.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.maps.sightlines import in_sight
from hexwar_sb3.viewer.map_block import map_block

REACH = 25
SMALL = (("hills", 8), ("plain@5", 8))
LARGE = (("plain", 200), ("hills", 200), ("paddy", 200), ("hills@11", 200), ("paddy@12", 200))


def fixture(maps: Iterable[tuple[str, int]]) -> dict[str, Any]:
    """Maps, some of their cells, and for each the hash of the cells that it sees: ground, one end in the air, both."""
    worlds = [(load_world(name), count) for name, count in maps]
    air = int(worlds[0][0].rules[0].air_height_m)
    return {"air_height_m": air, "reach": REACH, "maps": [_of(world, count) for world, count in worlds]}


def _of(world: World, count: int) -> dict[str, Any]:
    cells = np.random.default_rng(count).choice(np.flatnonzero(world.cells.playable), count, replace=False)
    seen = [[_hash(np.flatnonzero(row)) for row in _seen(world, int(cell))] for cell in cells]
    return {"map": map_block(world.scenario.hexmap), "cells": cells.tolist(), "seen": seen}


def _seen(world: World, cell: int) -> Any:
    """Cells in line of sight of a cell [airborne ends, NC], itself too."""
    rows, here = world.cells, world.cells[cell]
    dq, dr = rows.q - here.q, rows.r - here.r
    near = (abs(dq) + abs(dr) + abs(dq + dr)) // 2 <= REACH
    seen = np.array([in_sight(world.los, airborne, cell, rows) for airborne in range(3)])
    seen[:, cell] = True
    return seen & near & (rows.playable == 1)


def _hash(cells: Any) -> str:
    value = 0x811C9DC5
    for cell in cells.tolist():
        for byte in (cell & 255, cell >> 8):
            value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return f"{value:x}"


if __name__ == "__main__":
    place = Path(__file__).parents[2] / "viewer" / "test" / "los.json"
    place.write_text(json.dumps(fixture(SMALL)) + "\n", encoding="utf-8")
