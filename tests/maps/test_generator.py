"""The generator, and what rules.md, section 1, asks of the three built-in maps."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.files import BUILTIN, load_map, load_scenario
from hexwar_sb3.maps.generator import generate, standard_scenario
from hexwar_sb3.maps.geometry import Bools, neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.landscape import Canvas
from hexwar_sb3.maps.sightlines import lines_to
from hexwar_sb3.maps.spec import MAP_SPECS, Start
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.maps.travel import TOO_FAR
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import Camp, HopClass, PieceType
from hexwar_sb3.tasks.hotspots import is_mirrored

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


@pytest.mark.parametrize("name", MAP_SPECS)
def test_lakes_are_few_and_convex(name: str) -> None:
    """At most 5 % impassable, 3 % of a usual map; every line between two cells of a lake stays in the lake."""
    hexmap = load_map(name)
    water = hexmap.playable & ~hexmap.passable
    assert 0 < water.sum() <= (0.03 if name in ASKED else 0.05) * hexmap.playable.sum()
    for lake in patches(water, hexmap):
        assert_convex(lake, hexmap.width)


def assert_convex(lake: set[int], width: int) -> None:
    cube = {c: (c % width - (c // width - (c // width & 1)) // 2, c // width) for c in lake}
    inside = set(cube.values())
    for q, r in inside:
        for to_q, to_r in inside:
            for line in lines_to(to_q - q, to_r - r).tolist():
                assert all((q + dq, r + dr) in inside for dq, dr in line)


@pytest.mark.parametrize("name", MAP_SPECS)
def test_control_points_lie_in_open_level_clearings(name: str) -> None:
    """The 7 cells: passable, slope at most 2, not concealed, not slushy."""
    scenario = load_scenario(name)
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


@pytest.mark.parametrize("name", MAP_SPECS)
def test_builtin_files_are_what_their_seed_makes(name: str) -> None:
    spec, scenario = MAP_SPECS[name], load_scenario(name)
    assert scenario.hexmap.seed == spec.seed
    assert generate(spec).hash == scenario.hexmap.hash
    assert standard_scenario(scenario.hexmap, spec.start).hash == scenario.hash


@pytest.mark.parametrize("name", [name for name, spec in MAP_SPECS.items() if spec.mirror])
def test_points_of_mirrored_maps_are_their_own_images(name: str) -> None:
    """Both camps are told of the points in one order: a pair of mirrored ones would be near and far, then far and near."""
    world = load_world(name)
    assert all(world.cells["mirror"][point.cell] == point.cell for point in world.scenario.points)


@pytest.mark.parametrize("name", MAP_SPECS)
def test_one_seed_makes_one_map_and_another_seed_another(name: str) -> None:
    spec = MAP_SPECS[name]
    assert generate(spec).hash == generate(spec).hash
    other = generate(replace(spec, seed=99))
    assert other.hash != generate(spec).hash
    assert other.is_symmetric() == spec.mirror
    assert standard_scenario(other, spec.start).hexmap is other


@pytest.mark.parametrize("mirror", [True, False])
@pytest.mark.parametrize("size", [(15, 11), (20, 11), (21, 30), (50, 16), (121, 90)])
@pytest.mark.parametrize("name", MAP_SPECS)
def test_every_map_can_be_had_in_any_size(name: str, size: tuple[int, int], mirror: bool) -> None:
    """One piece of land, with room for both camps; alike west and east if asked for."""
    spec = replace(MAP_SPECS[name].resized(*size), seed=7, mirror=mirror)
    hexmap = generate(spec)
    scenario = standard_scenario(hexmap, replace(spec.start, pieces=(16, 16)))

    assert (hexmap.width, hexmap.height) == size
    assert hexmap.is_symmetric() == mirror
    assert len(patches(hexmap.passable, hexmap)) == 1
    assert Counter(piece.camp for piece in scenario.pieces) == {Camp.RED: 16, Camp.BLUE: 16}
    assert len(scenario.points) == len(spec.start.points)
    assert is_mirrored(scenario) == (mirror and spec.start.blue_base is None)


def test_a_map_of_its_own_size_is_the_same() -> None:
    for spec in MAP_SPECS.values():
        assert spec.resized(spec.width, spec.height) == spec


@pytest.mark.parametrize("size", [(14, 30), (30, 10), (251, 30), (30, 251)])
def test_a_size_out_of_range_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ConfigError, match=r"(width|height) must be (an integer >= 1[15]|at most 250), got"):
        MAP_SPECS["plain"].resized(*size)


def test_camps_grow_by_whole_squads_whose_soldiers_ride() -> None:
    names = [name for name, _ in Start().camp(10, 70)]
    assert names == [
        "tank0", "tank1", "tank2", "chariot0", "chariot1", "chariot2", "soldier0", "soldier1", "soldier2", "aerocraft0"
    ]  # fmt: skip
    pieces = standard_scenario(load_map("plain"), Start(pieces=(64, 3))).pieces
    assert Counter(piece.camp for piece in pieces) == {Camp.RED: 64, Camp.BLUE: 3}
    homes = {(piece.camp, piece.name): piece.cell for piece in pieces}
    assert all(homes[piece.camp, piece.home] == piece.cell for piece in pieces if piece.home)


@pytest.mark.parametrize("pieces", [(0, 7), (7, 65)])
def test_camps_of_no_size_are_refused(pieces: tuple[int, int]) -> None:
    with pytest.raises(ConfigError, match=r"pieces must be (an integer >= 1, got 0|at most 64, got 65)"):
        Start(pieces=pieces)


def test_a_map_that_is_too_full_is_refused() -> None:
    small = MAP_SPECS["plain"].resized(15, 11)
    with pytest.raises(ConfigError, match="no free dry cells left"):
        standard_scenario(generate(replace(small, slushy=0.9)), Start(pieces=(64, 64)))


def test_distance_counts_cells() -> None:
    canvas = Canvas(9, 8, np.random.default_rng(0))
    marks = np.zeros((8, 9), np.bool_)
    marks[0, 0] = True
    distance = canvas.distance(marks)
    assert distance[0, 8] == 8
    assert distance[7, 0] == 7
    assert np.isinf(canvas.distance(marks & False)).all()
