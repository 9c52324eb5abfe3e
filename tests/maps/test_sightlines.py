"""Lines of sight (rules.md, section 6) against an obvious slow reading of the rule."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hexwar_sb3.maps.geometry import cells_apart, cube_coordinates, mirror_cells, playable_mask
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.sightlines import AIR_AIR, AIR_GROUND, GROUND_GROUND, in_sight, line_of_sight
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.indices import CellIndex

SIGHT_CELLS, AIR_HEIGHT_M = 25, 200
ENDS = [(0, 0), (1, 0), (0, 1), (1, 1)]  # is a airborne, is b airborne


def bits(terrain: Terrain) -> npt.NDArray[np.bool_]:
    """The matrices of a map [airborne ends, a, b]."""
    return np.array(
        [
            [in_sight(terrain.los, airborne, a, terrain.cells) for a in range(terrain.hexmap.n_cells)]
            for airborne in (GROUND_GROUND, AIR_GROUND, AIR_AIR)
        ]
    )


def rounded(q: float, r: float) -> tuple[int, int]:
    """The cell that holds a point in cube coordinates."""
    s = -q - r
    rq, rr, rs = round(q), round(r), round(s)
    errors = [abs(rq - q), abs(rr - r), abs(rs - s)]
    if errors[0] == max(errors):
        return -rr - rs, rr
    if errors[1] == max(errors):
        return rq, -rq - rs
    return rq, rr


@lru_cache
def cell_table(width: int, height: int) -> tuple[list[int], list[int], dict[tuple[int, int], int]]:
    """Cube coordinates of every cell, and the playable cell at each."""
    q, r = (coordinate.tolist() for coordinate in cube_coordinates(width, height))
    playable = np.flatnonzero(playable_mask(width, height)).tolist()
    return q, r, {(q[c], r[c]): c for c in playable}


def slow_sight(hexmap: HexMap, a: int, b: int, a_flies: int, b_flies: int) -> bool:
    """Section 6 word by word: both nudges, heights as fractions."""
    q, r, where = cell_table(hexmap.width, hexmap.height)
    dq, dr = q[b] - q[a], r[b] - r[a]
    n = (abs(dq) + abs(dr) + abs(dq + dr)) // 2
    h_a = Fraction(int(hexmap.elev_m.flat[a]) + AIR_HEIGHT_M * a_flies, hexmap.grade_m)
    h_b = Fraction(int(hexmap.elev_m.flat[b]) + AIR_HEIGHT_M * b_flies, hexmap.grade_m)
    h_a, h_b = h_a + (h_a > h_b), h_b + (h_b > h_a)

    def is_clear(nudge: float) -> bool:
        for i in range(1, n):
            point = rounded(q[a] + dq * i / n + nudge, r[a] + dr * i / n + 2 * nudge)
            cell = where.get(point)
            if cell is None:
                return False
            top = Fraction(int(hexmap.elev_m.flat[cell]), hexmap.grade_m) + int(hexmap.concealed.flat[cell])
            if top > h_a + (h_b - h_a) * Fraction(i, n):
                return False
        return True

    return n <= SIGHT_CELLS and (is_clear(1e-6) or is_clear(-1e-6))


def see(terrain: Terrain, airborne: int, a: int, b: int) -> bool:
    return bool(line_of_sight(terrain.los, airborne, CellIndex(a), CellIndex(b), terrain.cells))


def fast_sight(terrain: Terrain, a: int, b: int, a_flies: int, b_flies: int) -> bool:
    """By the kernel, and by all that a cell sees."""
    one, other = (a, b) if a_flies >= b_flies else (b, a)
    found = see(terrain, a_flies + b_flies, one, other)
    assert in_sight(terrain.los, a_flies + b_flies, one, terrain.cells)[other] == found
    return found


@pytest.mark.usefixtures("own_cache")
@pytest.mark.parametrize("seed", range(3))
def test_all_pairs_of_a_rough_map_agree_with_the_slow_rule(rough_board: Any, seed: int) -> None:
    hexmap = rough_board(seed, width=8, height=9)
    terrain = Terrain(hexmap, default_rules())
    playable = np.flatnonzero(hexmap.playable).tolist()
    for a in playable:
        for b in playable:
            for ends in ENDS:
                assert fast_sight(terrain, a, b, *ends) == slow_sight(hexmap, a, b, *ends), (a, b, ends)


def test_random_pairs_of_the_builtin_maps_agree_with_the_slow_rule(terrain: Terrain) -> None:
    rng = np.random.default_rng(0)
    playable = np.flatnonzero(terrain.hexmap.playable)
    pairs = rng.choice(playable, (3000, 2)).tolist()
    near = [(a, b) for a, b in pairs if cells_apart(terrain.cells, a, b) <= SIGHT_CELLS + 2]
    assert len(near) > 500
    for a, b in near[:500]:
        for ends in ENDS:
            assert fast_sight(terrain, a, b, *ends) == slow_sight(terrain.hexmap, a, b, *ends)


def test_sight_is_mutual(terrain: Terrain) -> None:
    matrices = bits(terrain)
    for ends in (GROUND_GROUND, AIR_AIR):
        assert (matrices[ends] == matrices[ends].T).all()


def test_sight_is_the_same_in_the_mirror(terrain: Terrain) -> None:
    mirror = mirror_cells(terrain.hexmap.width, terrain.hexmap.height)
    for matrix in bits(terrain):
        assert (matrix[np.ix_(mirror, mirror)] == matrix).all()


def test_the_mirrored_map_has_the_mirrored_sight(rough_board: Any) -> None:
    hexmap = rough_board(5)
    mirror = mirror_cells(hexmap.width, hexmap.height)
    here = bits(Terrain(hexmap, default_rules()))
    there = bits(Terrain(hexmap.mirrored(), default_rules()))
    assert (there[:, mirror][:, :, mirror] == here).all()


def test_void_cells_neither_see_nor_are_seen(terrain: Terrain) -> None:
    matrices = bits(terrain)
    void = ~terrain.hexmap.playable.ravel()
    assert not matrices[:, void].any()
    assert not matrices[:, :, void].any()


def test_a_cell_sees_itself_and_its_neighbours_whatever_stands_there(board: Any) -> None:
    terrain = Terrain(board("fff\nff\nfff", "0 30 0\n30 0\n0 30 0"), default_rules())
    for b in (4, 3, 1, 2, 7, 8):
        assert see(terrain, GROUND_GROUND, 4, b)


def one_row(board: Any, symbols: str, levels: str) -> Terrain:
    """A map whose middle even row is given, with walls on both sides."""
    even, odd = " ".join(["60"] * 11), " ".join(["60"] * 10)
    terrain = "\n".join(["." * 11, "." * 10, symbols, "." * 10, "." * 11])
    return Terrain(board(terrain, f"{even}\n{odd}\n{levels}\n{odd}\n{even}"), default_rules())


def sees_from_end_to_end(terrain: Terrain, airborne: int = GROUND_GROUND) -> bool:
    return see(terrain, airborne, 22, 32)


def test_level_open_ground_does_not_block(board: Any) -> None:
    assert sees_from_end_to_end(one_row(board, "...........", "0 0 0 0 0 0 0 0 0 0 0"))


def test_a_forest_between_equal_heights_blocks(board: Any) -> None:
    assert not sees_from_end_to_end(one_row(board, ".....f.....", "0 0 0 0 0 0 0 0 0 0 0"))


def test_a_forest_at_the_ends_does_not_block(board: Any) -> None:
    assert sees_from_end_to_end(one_row(board, "f.........f", "0 0 0 0 0 0 0 0 0 0 0"))


def test_the_higher_end_looks_from_one_level_more(board: Any) -> None:
    """From level 1 (raised to 2) the line stands exactly at level 1 halfway."""
    assert sees_from_end_to_end(one_row(board, ".....f.....", "1 0 0 0 0 0 0 0 0 0 0"))
    assert not sees_from_end_to_end(one_row(board, "......f....", "1 0 0 0 0 0 0 0 0 0 0"))


def test_an_aerocraft_sees_over_a_forest(board: Any) -> None:
    assert sees_from_end_to_end(one_row(board, ".....f.....", "0 0 0 0 0 0 0 0 0 0 0"), AIR_GROUND)


def test_a_line_between_two_cells_is_blocked_only_on_both_sides(board: Any) -> None:
    """From (1, 0) to (1, 2) the line runs between (0, 1) and (1, 1)."""
    a, b = 1, 7
    for symbols, expected in (("ff", False), ("f.", True), (".f", True), ("..", True)):
        terrain = Terrain(board(f"...\n{symbols}\n..."), default_rules())
        assert see(terrain, GROUND_GROUND, a, b) is expected


def test_void_at_the_edge_blocks(board: Any) -> None:
    """From (0, 0) to (0, 2) the line runs between (0, 1) and nothing."""
    assert not see(Terrain(board("...\nf.\n..."), default_rules()), GROUND_GROUND, 0, 6)
    assert see(Terrain(board("...\n..\n..."), default_rules()), GROUND_GROUND, 0, 6)


def test_exposure_is_the_share_of_near_cells_that_see_a_cell(terrain: Terrain) -> None:
    cells, near, seen = terrain.cells, 0, 0
    target = 34 * terrain.hexmap.width + 30
    for cell in np.flatnonzero(terrain.hexmap.playable).tolist():
        if cell != target and cells_apart(cells, CellIndex(target), CellIndex(cell)) <= 15:
            near += 1
            seen += see(terrain, GROUND_GROUND, cell, target)
    assert cells[target].exposure == np.float32(seen / near)
