"""Small maps written as text, and the built-in ones compiled."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.maps.files import load_scenario, map_from_document
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import SYMBOLS
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.rules import default_rules

Board = Callable[..., HexMap]
BUILTIN = ("hills", "paddy", "plain")


def make_board(terrain: str, levels: str | None = None) -> HexMap:
    """A map from rows of terrain symbols and rows of levels (none: flat)."""
    rows = terrain.split()
    flat = [" ".join("0" * len(row)) for row in rows]
    document = {
        "format": "hexwar-map",
        "version": 1,
        "name": "board",
        "width": len(rows[0]),
        "height": len(rows),
        "grade_m": 10,
        "controllable": [],
        "terrain": rows,
        "levels": flat if levels is None else levels.strip().splitlines(),
    }
    return map_from_document(document, "board")


def make_rough_board(seed: int, width: int = 13, height: int = 12) -> HexMap:
    """An asymmetric map of random terrain and steep random levels."""
    rng = np.random.default_rng(seed)
    lengths = [width - (y & 1) for y in range(height)]
    symbols = list(SYMBOLS)
    terrain = ("".join(rng.choice(symbols, n)) for n in lengths)
    levels = (" ".join(map(str, rng.choice([0, 0, 1, 2, 3, 5, 8, 20], n))) for n in lengths)
    return make_board("\n".join(terrain), "\n".join(levels))


@lru_cache
def builtin_scenario(name: str) -> Scenario:
    return load_scenario(name)


@lru_cache
def builtin_terrain(name: str) -> Terrain:
    return Terrain(builtin_scenario(name).hexmap, default_rules())


@pytest.fixture
def board() -> Board:
    return make_board


@pytest.fixture
def rough_board() -> Board:
    return make_rough_board


@pytest.fixture(params=BUILTIN)
def scenario(request: pytest.FixtureRequest) -> Scenario:
    return builtin_scenario(request.param)


@pytest.fixture(params=BUILTIN)
def terrain(request: pytest.FixtureRequest) -> Terrain:
    return builtin_terrain(request.param)


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder of the test's own."""
    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path))
    return tmp_path
