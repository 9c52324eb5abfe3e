"""Hop times (rules.md, section 1) and fastest travel times."""

from __future__ import annotations

import gc
import heapq
from concurrent.futures import ThreadPoolExecutor
from typing import Any, cast

import numpy as np
import pytest

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.maps.cells import NO_CELL, NO_HOP, TravelTimes
from hexwar_sb3.maps.geometry import E, W, mirror_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.maps.travel import TOO_FAR, no_times, row_of, row_to
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import HopClass
from hexwar_sb3.rules.indices import CellIndex

VEHICLE, SOLDIER = HopClass.VEHICLE, HopClass.SOLDIER
BASE = {VEHICLE: 20, SOLDIER: 144}


def hop(board: Any, symbols: str, levels: str, hop_class: HopClass = VEHICLE) -> int:
    """Ticks from the first to the second cell of a row of three."""
    terrain = Terrain(board(f"...\n..\n{symbols}", f"0 0 0\n0 0\n{levels}"), default_rules())
    return int(terrain.cells[6].hop_ticks[hop_class, E])


@pytest.mark.parametrize(
    ("symbols", "levels", "ticks"),
    [
        ("...", "0 0 0", 20),
        ("...", "0 1 0", 20),
        ("...", "0 2 0", 40),
        ("...", "2 0 0", 40),
        ("...", "0 5 0", 100),
        ("...", "0 6 0", NO_HOP),
        ("...", "6 0 0", NO_HOP),
        (".f.", "0 0 0", 40),
        ("f..", "0 0 0", 20),
        (".m.", "0 0 0", 80),
        (".w.", "0 0 0", 80),
        (".m.", "0 3 0", 240),
        ("==.", "0 0 0", 20),
        ("==.", "0 9 0", 20),
        ("=e.", "0 4 0", 20),
        (".=.", "0 4 0", 80),
        (".d.", "0 0 0", 80),
        (".~.", "0 0 0", NO_HOP),
        (".^.", "0 0 0", NO_HOP),
        ("=x.", "0 0 0", NO_HOP),
    ],
)
def test_hop_time_of_a_vehicle(board: Any, symbols: str, levels: str, ticks: int) -> None:
    assert hop(board, symbols, levels) == ticks


@pytest.mark.parametrize(
    ("symbols", "levels", "ticks"),
    [
        ("...", "0 0 0", 144),
        ("...", "0 6 0", 144),
        ("...", "0 7 0", 288),
        ("...", "7 0 0", 288),
        ("...", "0 40 0", 288),
        (".m.", "0 0 0", 144),
        (".f.", "0 0 0", 144),
        ("==.", "0 0 0", 144),
        (".~.", "0 0 0", NO_HOP),
    ],
)
def test_hop_time_of_a_soldier(board: Any, symbols: str, levels: str, ticks: int) -> None:
    assert hop(board, symbols, levels, SOLDIER) == ticks


def test_there_is_no_hop_off_the_map(board: Any) -> None:
    cells = Terrain(board("...\n..\n..."), default_rules()).cells
    assert cells[6].hop_ticks[:, W].tolist() == [NO_HOP, NO_HOP]
    assert cells[5].hop_ticks.any() == NO_HOP  # void
    assert cells[4].hop_ticks[:, E].tolist() == [NO_HOP, NO_HOP]  # into void


def slow_times(terrain: Terrain, hop_class: HopClass, start: int) -> dict[int, int]:
    """Ticks from one cell to every other, by the textbook's search along the hops."""
    cells = terrain.cells
    best, heap = {start: 0}, [(0, start)]
    while heap:
        ticks, cell = heapq.heappop(heap)
        if ticks > best[cell]:
            continue
        hops = zip(cells[cell].neighbour.tolist(), cells[cell].hop_ticks[hop_class].tolist(), strict=True)
        for neighbour, need in hops:
            if need != NO_HOP and ticks + need < best.get(neighbour, 10**9):
                best[neighbour] = ticks + need
                heapq.heappush(heap, (ticks + need, neighbour))
    return best


def check_from(terrain: Terrain, hop_class: HopClass, start: int, every: int = 1) -> None:
    """Times from a cell to all, and from all to it; the latter for one target in `every`."""
    best, times = slow_times(terrain, hop_class, start), terrain.times_from(hop_class, start)
    for target in np.flatnonzero(terrain.hexmap.passable).tolist():
        ticks = best.get(target)
        units = TOO_FAR if ticks is None else min(ticks // BASE[hop_class], TOO_FAR)
        assert times[target] == units, (start, target)
        if target % every == 0:
            assert terrain.times_to(hop_class, target)[start] == units, (start, target)


@pytest.mark.usefixtures("own_cache")
@pytest.mark.parametrize("hop_class", HopClass)
@pytest.mark.parametrize("seed", range(2))
def test_times_on_a_rough_map_equal_a_plain_search(rough_board: Any, seed: int, hop_class: HopClass) -> None:
    terrain = Terrain(rough_board(seed), default_rules())
    for start in np.flatnonzero(terrain.hexmap.passable).tolist():
        check_from(terrain, hop_class, start)


@pytest.mark.parametrize("hop_class", HopClass)
def test_times_on_builtin_maps_equal_a_plain_search(terrain: Terrain, hop_class: HopClass) -> None:
    for start in np.random.default_rng(1).choice(np.flatnonzero(terrain.hexmap.passable), 3).tolist():
        check_from(terrain, hop_class, start, every=7)


def test_nothing_reaches_an_impassable_cell(terrain: Terrain) -> None:
    barred = np.flatnonzero(~terrain.hexmap.passable)
    for hop_class in HopClass:
        assert (terrain.times_to(hop_class, int(barred[0])) == TOO_FAR).all()
        assert (terrain.times_from(hop_class, 34 * terrain.hexmap.width + 35)[barred] == TOO_FAR).all()


def test_some_next_hop_always_lies_on_a_fastest_path(terrain: Terrain) -> None:
    """What the route planner relies on: hop time + rest = time, for every cell and some direction."""
    cells, target = terrain.cells, 34 * terrain.hexmap.width + 35
    eta = terrain.times_to(VEHICLE, target).astype(int)
    for cell in np.flatnonzero(eta < TOO_FAR).tolist():
        if cell == target:
            continue
        neighbours, ticks = cells[cell].neighbour, cells[cell].hop_ticks[VEHICLE]
        rest = [eta[n] + t // BASE[VEHICLE] for n, t in zip(neighbours, ticks, strict=True) if t != NO_HOP]
        assert min(rest) == eta[cell]


def test_times_are_the_same_in_the_mirror(terrain: Terrain) -> None:
    mirror = mirror_cells(terrain.hexmap.width, terrain.hexmap.height)
    for hop_class in HopClass:
        for cell in np.random.default_rng(0).choice(np.flatnonzero(terrain.hexmap.passable), 20).tolist():
            there = terrain.times_to(hop_class, int(mirror[cell]))[mirror]
            assert (terrain.times_to(hop_class, cell) == there).all()


def test_kernels_ask_for_rows_and_the_oldest_goes_first(terrain: Terrain) -> None:
    cells, rules = terrain.cells, terrain.rules
    eta = no_times(cells.size)
    few = cast("Any", np.asarray(eta)[:7].copy())  # three rows
    rng = np.random.default_rng(0)
    targets = rng.choice(np.flatnonzero(terrain.hexmap.passable), 5).tolist()
    for target in [targets[k] for k in rng.integers(0, 5, 60)]:
        for hop_class in HopClass:
            times = terrain.times_to(hop_class, target)
            for start in rng.choice(cells.size, 20).tolist():
                assert few[row_to(hop_class, CellIndex(target), rules, cells, few), start] == times[start]
            rows = [row_of(k, CellIndex(cell), few) for k in HopClass for cell in targets]
            assert 1 <= len([row for row in rows if row > 0]) <= 3
            assert max(rows) < 7
            assert row_of(hop_class, CellIndex(target), few) > 0


def test_threads_have_their_own_rows_and_leave_them_to_the_next() -> None:
    world = load_world("plain")
    mine = world.eta
    assert world.eta is mine

    def theirs() -> TravelTimes:
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(lambda: world.eta).result()

    one = theirs()
    assert one is not mine
    gc.collect()
    assert theirs() is one


def test_a_road_that_only_touches_the_way_gives_nothing(board: Any) -> None:
    """Both cells of a hop must be paved."""
    hexmap: HexMap = board("...\n..\n=.=")
    assert Terrain(hexmap, default_rules()).cells[6].neighbour[E] != NO_CELL
    assert hop(board, "=.=", "0 3 0") == 60
