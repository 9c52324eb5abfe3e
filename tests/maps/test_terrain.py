"""Tables of a map: filed once, shared, and never trusted when damaged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.rules import default_rules

TABLES = ("cells", "los", "eta")


def tables(hexmap: HexMap) -> list[np.ndarray]:
    terrain = Terrain(hexmap, default_rules())
    return [getattr(terrain, name) for name in TABLES]


def equal(some: list[np.ndarray], others: list[np.ndarray]) -> bool:
    return all((a == b).all() for a, b in zip(some, others, strict=True))


def test_tables_are_filed_once_and_then_mapped(rough_board: Any, own_cache: Path) -> None:
    built = tables(rough_board(0, 50, 50))
    stamps = {path: path.stat().st_mtime_ns for path in (own_cache / "terrain").iterdir()}
    assert len(stamps) == len(TABLES)
    assert equal(tables(rough_board(0, 50, 50)), built)
    assert {path: path.stat().st_mtime_ns for path in (own_cache / "terrain").iterdir()} == stamps


@pytest.mark.usefixtures("own_cache")
def test_tables_of_small_maps_are_not_filed(rough_board: Any, tmp_path: Path) -> None:
    tables(rough_board(0))
    assert list(tmp_path.iterdir()) == []


def test_damaged_files_are_built_again(rough_board: Any, own_cache: Path) -> None:
    built = [table.copy() for table in tables(rough_board(0, 50, 50))]
    for path in (own_cache / "terrain").iterdir():
        path.write_bytes(path.read_bytes()[:200])
    assert equal(tables(rough_board(0, 50, 50)), built)


def test_a_cache_that_cannot_be_written_costs_time_only(
    rough_board: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path / "good"))
    built = tables(rough_board(0, 50, 50))
    monkeypatch.setenv("HEXWAR_CACHE", str(blocked))
    assert equal(tables(rough_board(0, 50, 50)), built)


@pytest.mark.usefixtures("own_cache")
def test_tables_cannot_be_written(rough_board: Any) -> None:
    assert not any(table.flags.writeable for table in tables(rough_board(0, 50, 50)))


def test_other_maps_and_other_movement_rules_have_other_tables(rough_board: Any) -> None:
    rules = default_rules()
    terrain = Terrain(rough_board(0, 50, 50), rules)
    assert Terrain(rough_board(1, 50, 50), rules).hash != terrain.hash
    assert Terrain(rough_board(0, 50, 50), rules.with_numbers(slushy_factor=3)).hash != terrain.hash
    assert Terrain(rough_board(0, 50, 50), rules.with_numbers(stop_ticks=50)).hash == terrain.hash


def test_cells_repeat_the_map(terrain: Terrain) -> None:
    cells, hexmap = terrain.cells, terrain.hexmap
    for layer in ("passable", "paved", "concealed", "slushy", "controllable", "playable"):
        assert (cells[layer] == getattr(hexmap, layer).ravel()).all()
    assert (cells.elev_m == hexmap.elev_m.ravel()).all()
    assert (cells.level * hexmap.grade_m == cells.elev_m).all()
    assert (cells.y * hexmap.width + cells.x == np.arange(hexmap.n_cells)).all()


def test_other_sizes_work(board: Any) -> None:
    """The smallest map, an odd height, and the longest side."""
    for width, height in ((3, 3), (4, 7), (99, 5)):
        rows = "\n".join("." * (width - (y & 1)) for y in range(height))
        terrain = Terrain(board(rows), default_rules())
        far = width * (height - 1)
        assert terrain.cells.size == width * height
        assert terrain.eta[0, 0, far] == height - 1
