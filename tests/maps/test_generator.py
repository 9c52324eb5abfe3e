"""The generator, and what rules.md, section 1, asks of the three built-in maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexwar_sb3.maps.files import BUILTIN, load_map, load_scenario
from hexwar_sb3.maps.generator import MAP_SPECS, generate, standard_scenario
from hexwar_sb3.maps.geometry import Bools, neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.landscape import Canvas
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.sightlines import lines_to
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.maps.travel import TOO_FAR
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import HopClass, PieceType

ASKED = {  # relief, share concealed, share slushy, roads
    "plain": (60, 0.15, 0.08, 1),
    "hills": (300, 0.30, 0.05, 2),
    "paddy": (40, 0.12, 0.30, 1),
}


@pytest.mark.parametrize("name", ASKED)
def test_relief_and_shares_are_as_asked(name: str) -> None:
    relief_m, concealed, slushy, _ = ASKED[name]
    hexmap = load_map(name)
    n_cells = hexmap.playable.sum()
    assert n_cells == 4935
    assert (hexmap.elev_m[hexmap.playable].min(), hexmap.elev_m.max()) == (0, relief_m)
    assert hexmap.concealed.sum() / n_cells == pytest.approx(concealed, abs=0.005)
    assert hexmap.slushy.sum() / n_cells == pytest.approx(slushy, abs=0.005)


@pytest.mark.parametrize("name", ASKED)
def test_every_road_leads_from_edge_to_edge(name: str) -> None:
    hexmap = load_map(name)
    roads = patches(hexmap.paved, hexmap)
    assert len(roads) == ASKED[name][3]
    for road in roads:
        assert {cell % hexmap.width for cell in road} >= set(range(hexmap.width - 1))


def patches(marks: Bools, hexmap: HexMap) -> list[set[int]]:
    """Groups of marked cells that hang together."""
    neighbours = neighbour_cells(hexmap.width, hexmap.height)
    left, groups = set(np.flatnonzero(marks).tolist()), []
    while left:
        group = edge = {left.pop()}
        while edge:
            edge = {n for c in edge for n in neighbours[c].tolist()} & left
            left -= edge
            group = group | edge
        groups.append(group)
    return groups


def test_lakes_are_few_and_convex(scenario: Scenario) -> None:
    """At most 3 % impassable; every line between two cells of a lake stays in the lake."""
    hexmap = scenario.hexmap
    water = hexmap.playable & ~hexmap.passable
    assert 0 < water.sum() <= 0.03 * hexmap.playable.sum()
    for lake in patches(water, hexmap):
        assert_convex(lake, hexmap.width)


def assert_convex(lake: set[int], width: int) -> None:
    cube = {c: (c % width - (c // width - (c // width & 1)) // 2, c // width) for c in lake}
    inside = set(cube.values())
    for q, r in inside:
        for to_q, to_r in inside:
            for line in lines_to(to_q - q, to_r - r).tolist():
                assert all((q + dq, r + dr) in inside for dq, dr in line)


def test_control_points_lie_in_open_level_clearings(scenario: Scenario) -> None:
    """The 7 cells: passable, slope at most 2, not concealed, not slushy."""
    hexmap = scenario.hexmap
    neighbours = neighbour_cells(hexmap.width, hexmap.height)
    for point in scenario.points:
        clearing = [point.cell, *neighbours[point.cell].tolist()]
        assert hexmap.passable.ravel()[clearing].all()
        assert not hexmap.concealed.ravel()[clearing].any()
        assert not hexmap.slushy.ravel()[clearing].any()
        assert np.ptp(hexmap.elev_m.ravel()[clearing]) <= 2 * hexmap.grade_m


@pytest.mark.parametrize("name", ASKED)
def test_vehicles_reach_the_main_point_in_480_to_900_ticks(name: str) -> None:
    scenario = load_scenario(name)
    terrain = Terrain(scenario.hexmap, default_rules())
    for piece in scenario.pieces:
        if piece.kind in (PieceType.TANK, PieceType.CHARIOT):
            assert (
                480
                <= 20 * int(terrain.times_to(HopClass.VEHICLE, scenario.points[0].cell)[piece.cell])
                <= 900
            )


def test_every_passable_cell_can_be_reached(terrain: Terrain) -> None:
    main = 34 * terrain.hexmap.width + 35
    passable = terrain.hexmap.passable.ravel()
    for hop_class in HopClass:
        assert (terrain.times_to(hop_class, main)[passable] < TOO_FAR).all()


def test_builtin_files_are_small() -> None:
    assert all(path.stat().st_size < 100_000 for path in BUILTIN.iterdir())


def test_builtin_files_are_what_their_seed_makes(scenario: Scenario) -> None:
    spec = MAP_SPECS[scenario.name]
    assert scenario.hexmap.seed == spec.seed
    assert generate(spec).hash == scenario.hexmap.hash
    assert standard_scenario(scenario.hexmap).hash == scenario.hash


@pytest.mark.parametrize("name", MAP_SPECS)
def test_one_seed_makes_one_map_and_another_seed_another(name: str) -> None:
    spec = MAP_SPECS[name]
    assert generate(spec).hash == generate(spec).hash
    other = generate(replace(spec, seed=99))
    assert other.hash != generate(spec).hash
    assert other.is_symmetric()
    assert standard_scenario(other).hexmap is other


def test_distance_counts_cells() -> None:
    canvas = Canvas(9, 8, np.random.default_rng(0))
    marks = np.zeros((8, 9), np.bool_)
    marks[0, 0] = True
    distance = canvas.distance(marks)
    assert distance[0, 8] == 8
    assert distance[7, 0] == 7
    assert np.isinf(canvas.distance(marks & False)).all()
