"""Geometry of rules.md, section 1, over all cells."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps import geometry
from hexwar_sb3.maps.cells import NO_CELL
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CellIndex

WIDTH, HEIGHT = 71, 70
ALL = range(WIDTH * HEIGHT)
STEPS = {  # even y, odd y; W SW SE E NE NW
    0: [(-1, 0), (-1, 1), (0, 1), (1, 0), (0, -1), (-1, -1)],
    1: [(-1, 0), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1)],
}


def is_playable(x: int, y: int) -> bool:
    return 0 <= y < HEIGHT and 0 <= x < WIDTH - (y & 1)


def test_the_default_size_has_4935_playable_cells() -> None:
    assert geometry.playable_mask(WIDTH, HEIGHT).sum() == 4935


def test_the_name_of_x_8_y_11_is_0912() -> None:
    assert geometry.cell_name(11 * WIDTH + 8, WIDTH, HEIGHT) == "0912"
    assert geometry.parse_cell("0912", WIDTH, HEIGHT) == 11 * WIDTH + 8


def test_every_name_reads_back_as_its_cell() -> None:
    playable = geometry.playable_mask(WIDTH, HEIGHT).ravel()
    for cell in np.flatnonzero(playable).tolist():
        assert geometry.parse_cell(geometry.cell_name(cell, WIDTH, HEIGHT), WIDTH, HEIGHT) == cell


@pytest.mark.parametrize(("width", "height"), [(99, 99), (100, 3), (3, 100), (250, 250)])
def test_names_have_six_digits_where_a_side_has_100_cells(width: int, height: int) -> None:
    names = [geometry.cell_name(cell, width, height) for cell in range(width * height)]
    assert {len(name) for name in names} == {4 if max(width, height) < 100 else 6}
    assert len(set(names)) == len(names)
    for cell in np.flatnonzero(geometry.playable_mask(width, height)).tolist():
        assert geometry.parse_cell(names[cell], width, height) == cell


@pytest.mark.parametrize("name", ["0912", "9012", "0090012", "000012", "251001", "250002"])
def test_a_name_of_another_length_is_no_cell_of_a_large_map(name: str) -> None:
    with pytest.raises(ConfigError, match=r"six digits|off the map"):
        geometry.parse_cell(name, 250, 250)


@pytest.mark.parametrize(
    "name", ["", "912", "09124", "ab12", "-912", "0012", "0100", "7202", "0171", "7102", "٠٩١٢"]
)
def test_a_name_that_is_no_cell_is_refused_with_the_name(name: str) -> None:
    with pytest.raises(ConfigError, match="cell"):
        geometry.parse_cell(name, WIDTH, HEIGHT)


def test_neighbours_are_those_of_the_rule_book() -> None:
    neighbours = geometry.neighbour_cells(WIDTH, HEIGHT)
    for cell in ALL:
        y, x = divmod(cell, WIDTH)
        for d, (dx, dy) in enumerate(STEPS[y & 1]):
            to = (y + dy) * WIDTH + x + dx
            expected = to if is_playable(x, y) and is_playable(x + dx, y + dy) else NO_CELL
            assert neighbours[cell, d] == expected


def test_every_neighbour_leads_back_by_the_opposite_direction() -> None:
    neighbours = geometry.neighbour_cells(WIDTH, HEIGHT)
    for d in range(6):
        cells = np.flatnonzero(neighbours[:, d] != NO_CELL)
        assert (neighbours[neighbours[cells, d], (d + 3) % 6] == cells).all()


def test_distance_equals_the_number_of_steps(terrain: Terrain) -> None:
    """Breadth-first search from a few cells against the cube formula, all targets."""
    cells = terrain.cells
    for start in (0, 69, 34 * WIDTH + 35, 69 * WIDTH):
        steps = {start: 0}
        queue = deque([start])
        while queue:
            cell = queue.popleft()
            for neighbour in cells[cell].neighbour.tolist():
                if neighbour != NO_CELL and neighbour not in steps:
                    steps[neighbour] = steps[cell] + 1
                    queue.append(neighbour)
        assert len(steps) == 4935
        assert all(
            geometry.cells_apart(cells, CellIndex(start), CellIndex(cell)) == n for cell, n in steps.items()
        )


def test_the_mirror_map_is_its_own_inverse_and_keeps_neighbourhood() -> None:
    mirror = geometry.mirror_cells(WIDTH, HEIGHT)
    neighbours = geometry.neighbour_cells(WIDTH, HEIGHT)
    assert (mirror[mirror] == np.arange(mirror.size)).all()
    for d, image in enumerate(geometry.MIRROR_DIRECTION):
        to = neighbours[:, d]
        expected = np.where(to == NO_CELL, NO_CELL, mirror[to])
        assert (neighbours[mirror, image] == expected).all()


def test_the_axis_is_column_35_of_even_rows() -> None:
    mirror = geometry.mirror_cells(WIDTH, HEIGHT)
    playable = geometry.playable_mask(WIDTH, HEIGHT).ravel()
    fixed = np.flatnonzero((mirror == np.arange(mirror.size)) & playable)
    assert fixed.tolist() == [y * WIDTH + 35 for y in range(0, HEIGHT, 2)]


def test_frames_of_the_camps(terrain: Terrain) -> None:
    """Red's frame is the map; blue's is the mirrored map."""
    cells = terrain.cells
    assert geometry.frame_cell(cells, CellIndex(7), Camp.RED) == 7
    assert geometry.frame_cell(cells, CellIndex(7), Camp.BLUE) == cells[7].mirror
    assert geometry.frame_cell(cells, NO_CELL, Camp.BLUE) == NO_CELL
    assert [geometry.frame_direction(d, Camp.RED) for d in range(6)] == [0, 1, 2, 3, 4, 5]
    assert [geometry.frame_direction(d, Camp.BLUE) for d in range(6)] == [3, 2, 1, 0, 5, 4]


def test_direction_between_neighbours(terrain: Terrain) -> None:
    cells = terrain.cells
    centre = CellIndex(34 * WIDTH + 35)
    for d in range(6):
        assert geometry.direction_between(cells, centre, cells[centre].neighbour[d]) == d
    assert geometry.direction_between(cells, centre, CellIndex(centre + 2)) == geometry.NO_DIRECTION
