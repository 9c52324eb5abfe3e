"""Tables of a map: filed once, shared, and never trusted when damaged."""

from __future__ import annotations

import copy
import io
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import HopClass

TABLES = ("cells", "los")


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
    tables(rough_board(0, 8, 9))
    assert list(tmp_path.iterdir()) == []


def saved(table: np.ndarray) -> Callable[[bytes], bytes]:
    """What numpy's own files would hold."""
    file = io.BytesIO()
    np.save(file, table)
    return lambda _: file.getvalue()


OTHER_CONTENTS: dict[str, Callable[[bytes], bytes]] = {
    "cut": lambda old: old[:200],
    "empty": lambda _: b"",
    "one bit": lambda old: old[:-77] + bytes([old[-77] ^ 1]) + old[-76:],
    "reversed": lambda old: old[:4096] + old[:4095:-1],
    "zeros": lambda old: old[:4096] + bytes(len(old) - 4096),
    "longer": lambda old: old + old[-16:],
    "another shape": saved(np.zeros((3, 40, 40), np.uint8)),
    "another type": saved(np.zeros((3, 50 * 50, 51, 7), np.float32)),
    "the right form": saved(np.zeros((3, 50 * 50, 51, 7), np.uint8)),
    "objects": saved(np.array([{}, []], object)),
}


@pytest.mark.parametrize("content", OTHER_CONTENTS)
def test_files_of_another_shape_type_or_content_are_built_again(
    content: str, rough_board: Any, own_cache: Path
) -> None:
    built = [table.copy() for table in tables(rough_board(0, 50, 50))]
    whole = {path: path.read_bytes() for path in (own_cache / "terrain").iterdir()}
    for path, old in whole.items():
        path.write_bytes(OTHER_CONTENTS[content](old))
    assert equal(tables(rough_board(0, 50, 50)), built)
    assert {path: path.read_bytes() for path in whole} == whole


def test_files_of_another_map_are_built_again(rough_board: Any, own_cache: Path) -> None:
    built = [table.copy() for table in tables(rough_board(0, 50, 50))]
    mine = sorted((own_cache / "terrain").iterdir())
    tables(rough_board(1, 50, 50))
    others = sorted(set((own_cache / "terrain").iterdir()) - set(mine))
    for path, other in zip(mine, others, strict=True):
        path.write_bytes(other.read_bytes())
    assert equal(tables(rough_board(0, 50, 50)), built)


@pytest.mark.usefixtures("own_cache")
def test_tables_from_a_file_have_the_type_of_built_ones(rough_board: Any) -> None:
    """Kernels are compiled for a type of array, read-only and order included."""
    built, mapped = (tables(rough_board(0, 50, 50)) for _ in range(2))
    small = tables(rough_board(0, 8, 9))
    for three in zip(built, mapped, small, strict=True):
        assert len({str(numba.typeof(table)) for table in three}) == 1  # type: ignore[no-untyped-call]


@pytest.mark.usefixtures("own_cache")
def test_copies_share_the_tables(rough_board: Any) -> None:
    terrain = Terrain(rough_board(0, 50, 50), default_rules())
    assert copy.deepcopy(terrain) is terrain
    assert copy.copy(terrain) is terrain
    arrived = pickle.loads(pickle.dumps(terrain))  # noqa: S301
    assert arrived.hash == terrain.hash
    assert not any(getattr(arrived, name).flags.writeable for name in TABLES)


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
        assert terrain.times_to(HopClass.VEHICLE, 0)[far] == height - 1
