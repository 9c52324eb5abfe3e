"""Hot spots: the shipped files and the static rule."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.maps.files import builtin_names
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks import spots
from hexwar_sb3.tasks.spots import APART_CELLS, FOLDER, RINGS, load_spots, spots_document, static_spots

if TYPE_CHECKING:
    from tests.tasks.conftest import Board


@pytest.mark.parametrize("name", builtin_names())
def test_the_shipped_file_is_of_this_map_and_of_its_source(name: str) -> None:
    """A file of the static rule must still be what the rule says; run `spots_document` after a change."""
    shipped = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    made = spots_document(load_world(name))

    assert shipped["map_hash"] == made["map_hash"]
    assert shipped["source"] != "static rule" or shipped == made


@pytest.mark.parametrize("name", builtin_names())
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


def test_each_camp_gets_the_static_rule_in_its_own_frame(board: Board) -> None:
    red, blue = (static_spots(board.world, camp, 6) for camp in (Camp.RED, Camp.BLUE))
    assert blue == [int(board.cells[cell].mirror) for cell in red]


def test_a_map_without_a_file_or_of_another_content_falls_back(field: Board) -> None:
    assert load_spots(field.world, 4).shape == (2, 6)
    assert load_spots(field.world, 0)[0].tolist() == [point.cell for point in field.world.scenario.points]


def test_a_broken_file_says_where(board: Board, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    document = spots_document(board.world) | {"cells": ["9999"]}
    (tmp_path / "plain.json").write_text(json.dumps(document), encoding="utf-8")
    monkeypatch.setattr(spots, "FOLDER", tmp_path)
    with pytest.raises(FileFormatError, match=r"plain\.json: cells: found \"9999\""):
        load_spots(board.world)
