"""Hot spots: the shipped files and the static rule."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks import spots
from hexwar_sb3.tasks.hotspots import static_hot_spots
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.spots import (
    APART_CELLS,
    FOLDER,
    RINGS,
    SPOTS,
    load_spots,
    max_spots,
    static_spots,
)

if TYPE_CHECKING:
    from hexwar_sb3.engine.world import World
    from tests.tasks.conftest import Board


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in place of that of the shipped files."""
    monkeypatch.setattr(spots, "FOLDER", tmp_path)
    return tmp_path


def static_cells(world: World, k: int) -> list[list[int]]:
    """Both camps' control points and cells of the static rule."""
    points = [point.cell for point in world.scenario.points]
    return [points + static_spots(world, camp, k) for camp in (Camp.RED, Camp.BLUE)]


@pytest.mark.parametrize("name", STANDARD)
def test_the_shipped_file_is_of_this_map_and_of_its_source(name: str) -> None:
    """A file of the static rule must still be what the rule says."""
    world = load_world(name)
    shipped = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))

    assert shipped["map_hash"] == world.scenario.hexmap.hash
    assert shipped["source"] != "static rule" or load_spots(world).tolist() == static_cells(world, SPOTS)


@pytest.mark.parametrize("name", STANDARD)
def test_spots_are_reachable_apart_and_mirrored(name: str) -> None:
    world = load_world(name)
    red, blue = load_spots(world)

    assert blue.tolist() == [int(world.cells[cell].mirror) for cell in red]
    assert len(set(red.tolist())) == len(red) == 8
    assert (world.cells[red].passable == 1).all()
    assert all(spots._apart(world, int(a))[red[red != a]].min() >= APART_CELLS for a in red)


def test_the_static_rule_looks_in_its_rings_with_lines_of_sight(board: Board) -> None:
    points = [point.cell for point in board.world.scenario.points]
    chosen = static_spots(board.world, Camp.RED, 6)

    for k, cell in enumerate(chosen):
        ring, point = RINGS[k // 2], points[k % 2]
        assert ring.nearest <= spots._apart(board.world, point)[cell] <= ring.farthest
    assert sum(spots._seen_from(board.world, points[k % 2])[cell] for k, cell in enumerate(chosen)) >= 4


def test_a_ring_that_leaves_the_map_takes_cells_of_the_map() -> None:
    world = Game.from_text("map plain-9x5\npoint main 0503 80\nred tank 0103\nblue tank 0903").world
    for camp in (Camp.RED, Camp.BLUE):
        chosen = static_spots(world, camp, 6)
        assert len(set(chosen)) == 6
        assert (world.cells.passable[chosen] == 1).all()


def test_each_camp_gets_the_static_rule_in_its_own_frame(board: Board) -> None:
    red, blue = (static_spots(board.world, camp, 6) for camp in (Camp.RED, Camp.BLUE))
    assert blue == [int(board.cells[cell].mirror) for cell in red]


def test_a_map_without_a_file_falls_back_to_the_static_rule(field: Board) -> None:
    assert load_spots(field.world, 4).tolist() == static_cells(field.world, 4)
    assert load_spots(field.world, 0)[0].tolist() == [point.cell for point in field.world.scenario.points]


@pytest.mark.parametrize("change", [{"schema": 1}, {"map_hash": "0"}, {}])
def test_a_shipped_file_is_used_if_it_is_of_this_map_and_schema_and_long_enough(
    board: Board, shipped: Path, change: dict[str, object]
) -> None:
    document = static_hot_spots(board.world).document()
    for camp in ("red", "blue"):
        document[camp]["cells"].reverse()
    (shipped / "plain.json").write_text(json.dumps(document | change), encoding="utf-8")
    filed = [cells[:2] + cells[:1:-1] for cells in static_cells(board.world, SPOTS)]

    assert (load_spots(board.world).tolist() == filed) == (not change)
    assert load_spots(board.world, SPOTS + 1).tolist() == static_cells(board.world, SPOTS + 1)


def test_a_broken_file_says_where(board: Board, shipped: Path) -> None:
    document = static_hot_spots(board.world).document()
    document["red"]["cells"] = ["9999"]
    (shipped / "plain.json").write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(FileFormatError, match=r"plain\.json: red\.cells: found \"9999\""):
        load_spots(board.world)


def test_a_named_file_must_be_of_the_map_and_hold_k_cells(board: Board, field: Board, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    static_hot_spots(board.world, 5).save(path)

    assert load_spots(board.world, 5, path).tolist() == static_cells(board.world, 5)
    with pytest.raises(FileFormatError, match=r"cells: found 5 of a camp; expected at least k = 6"):
        load_spots(board.world, 6, path)
    with pytest.raises(FileFormatError, match=r"map_hash: found .*; expected .*, the map plain-41x21"):
        load_spots(field.world, 5, path)


@pytest.mark.parametrize("k", [-1, 18, 400])
def test_k_out_of_range_is_refused(board: Board, k: int) -> None:
    """K_max = 40 rows: stop, recover, and hold and hide at 2 control points and 17 spots."""
    with pytest.raises(ConfigError, match=rf"k must be in 0\.\.17, got {k}: a task set has 40 rows"):
        load_spots(board.world, k)


def test_any_k_in_range_gives_task_sets_with_hold_and_hide_at_every_spot(board: Board) -> None:
    board.spots = load_spots(board.world, max_spots(board.world))

    listed = board.listed("tank0")

    for kind in (TaskKind.HOLD, TaskKind.HIDE):
        assert [cell for row, _, cell in listed if row == kind] == board.spots[Camp.RED].tolist()
