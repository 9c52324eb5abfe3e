"""What the lower level reads (features.ROUTE) and may answer (III-A), against boards that can be added up by hand."""

from __future__ import annotations

import heapq
import os
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.cells import NO_CELL, TravelTimes
from hexwar_sb3.maps.files import map_from_document
from hexwar_sb3.maps.geometry import NE, NW, SE, SW, E, W, mirror_cells
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import SYMBOLS
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.maps.travel import TOO_FAR, no_times
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import Camp, HopClass, PieceType
from hexwar_sb3.rules.indices import CellIndex
from hexwar_sb3.tasks.features import BOUND, MOST, PER_CELL, PER_DETOUR, PER_HOP, PER_LEVEL, feature_index
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.route import STAY, has_way, new_route_buffers, observe_route

TANK, SOLDIER, AEROCRAFT = PieceType.TANK, PieceType.SOLDIER, PieceType.AEROCRAFT
PLACES = feature_index("route", 1, 1, 1)
MIDDLE, GOAL = 12, 10  # of the board below: column 3 and column 1 of row 3
BOARD = """
    .....
    ....
    .=.~.
    .mf.
    .....
"""
LEVELS = """
    0 0 0 0 0
    0 2 6 0
    0 0 0 0 0
    0 0 0 0
    0 0 0 0 0
"""


def make_map(terrain: str, levels: str, controllable: tuple[str, ...] = ()) -> HexMap:
    """A map from rows of terrain symbols and rows of levels."""
    rows = terrain.split()
    return map_from_document(
        {
            "format": "hexwar-map",
            "version": 1,
            "name": "board",
            "width": len(rows[0]),
            "height": len(rows),
            "grade_m": 10,
            "controllable": list(controllable),
            "terrain": rows,
            "levels": [row.strip() for row in levels.strip().splitlines()],
        },
        "board",
    )


def rough_map(seed: int) -> HexMap:
    """A small asymmetric map of random terrain and steep random levels."""
    rng = np.random.default_rng(seed)
    lengths = [9 - (y & 1) for y in range(7)]
    symbols = [*SYMBOLS, *"....."]
    terrain = ("".join(rng.choice(symbols, n)) for n in lengths)
    levels = (" ".join(map(str, rng.choice([0, 0, 1, 2, 3, 5, 8, 20], n))) for n in lengths)
    return make_map("\n".join(terrain), "\n".join(levels))


@pytest.fixture(scope="module")
def board() -> Terrain:
    return Terrain(make_map(BOARD, LEVELS, ("0202",)), default_rules())


class View:
    """The state of the lower level, by the names of its features, and its mask."""

    def __init__(
        self, terrain: Terrain, kind: PieceType, cell: int, goal: int, *, camp: Camp = Camp.RED, ways: bool = True,
        task: TaskKind = TaskKind.HOLD,
    ) -> None:  # fmt: skip
        self.state, self.mask = observed(terrain, kind, cell, goal, camp=camp, ways=ways, task=task)

    def __getitem__(self, name: str) -> list[float]:
        return [round(float(value), 5) for value in self.state[PLACES[name]]]

    def around(self, feature: str) -> list[float]:
        """One number of all six neighbours, W SW SE E NE NW."""
        return [self[f"neighbour {d}: {feature}"][0] for d in range(6)]


@cache
def times_of(terrain: Terrain) -> TravelTimes:
    return no_times(terrain.cells.size)


def observed(
    terrain: Terrain, kind: PieceType, cell: int, goal: int, *, camp: Camp = Camp.RED, ways: bool = True,
    task: TaskKind = TaskKind.HOLD,
) -> tuple[NDArray[np.float32], NDArray[np.int8]]:  # fmt: skip
    states, masks = new_route_buffers(1)
    states[:], masks[:] = np.nan, -1  # whatever was there before
    observe_route(
        kind,
        camp,
        task,
        CellIndex(cell),
        CellIndex(goal),
        ways,
        terrain.rules,
        terrain.cells,
        times_of(terrain),
        states[0],
        masks[0],
    )
    return states[0], masks[0]


def test_it_tells_the_type_of_the_piece_and_the_kind_of_its_task(board: Terrain) -> None:
    for kind in PieceType:
        for task in TaskKind:
            view = View(board, kind, MIDDLE, GOAL, task=task)
            assert view["piece: type"] == np.eye(len(PieceType))[kind].tolist()
            assert view["piece: task kind"] == np.eye(len(TaskKind))[task].tolist()


def test_it_tells_where_the_goal_is_and_how_long_the_fastest_way(board: Terrain) -> None:
    """Two cells to the west, by road: two base hops."""
    view = View(board, TANK, MIDDLE, GOAL)

    assert view["goal: dx, dy, distance"] == pytest.approx([-2 * PER_CELL, 0.0, 2 * PER_CELL], abs=1e-5)
    assert view["goal: here"] == [0.0]
    assert view["goal: way"] == pytest.approx([2 * PER_HOP])


def test_the_way_is_counted_in_base_hops_of_the_type(board: Terrain) -> None:
    """From the marsh cell's far side: four base hops into marsh for a tank, one for a soldier or an aerocraft."""
    for kind, hops in ((TANK, 4), (SOLDIER, 1), (AEROCRAFT, 1)):
        assert View(board, kind, 15, 16)["goal: way"] == pytest.approx([hops * PER_HOP])


def test_it_tells_that_the_goal_is_reached(board: Terrain) -> None:
    view = View(board, TANK, GOAL, GOAL)
    assert view["goal: here"] == [1.0]
    assert view["goal: way"] == [0.0]
    assert view["goal: dx, dy, distance"] == [0.0, 0.0, 0.0]


def test_it_tells_what_the_six_cells_around_are(board: Terrain) -> None:
    """W road, SW marsh, SE forest, E lake, NE six levels up, NW two levels up and fit for a control point."""
    view = View(board, TANK, MIDDLE, GOAL)

    assert view.around("climb") == pytest.approx([0, 0, 0, 0, 6 * PER_LEVEL, 2 * PER_LEVEL])
    booleans = {d: view[f"neighbour {d}: controllable, passable, paved, concealed, slushy"] for d in range(6)}
    assert booleans == {
        W: [0, 1, 1, 0, 0],
        SW: [0, 1, 0, 0, 1],
        SE: [0, 1, 0, 1, 0],
        E: [0, 0, 0, 0, 0],
        NE: [0, 1, 0, 0, 0],
        NW: [1, 1, 0, 0, 0],
    }
    assert view.around("nearer") == [1, 0, -1, -1, -1, 0]


def test_ease_is_the_base_hop_time_by_the_hop_time(board: Terrain) -> None:
    """Rule book, section 1: marsh takes a vehicle four times as long, forest and two levels twice."""
    assert View(board, TANK, MIDDLE, GOAL).around("ease") == [1, 0.25, 0.5, 0, 0, 0.5]
    assert View(board, SOLDIER, MIDDLE, GOAL).around("ease") == [1, 1, 1, 0, 1, 1]
    assert View(board, AEROCRAFT, MIDDLE, GOAL).around("ease") == [1, 1, 1, 1, 1, 1]


def test_a_detour_is_what_a_direction_loses_against_the_fastest_way(board: Terrain) -> None:
    """SW: 4 into the marsh + 2 from there - 2; SE: 2 + 3 - 2; NW: 2 + 3 - 2; no way there: 0."""
    tank = View(board, TANK, MIDDLE, GOAL).around("detour")
    assert tank == pytest.approx([0, 4 * PER_DETOUR, 3 * PER_DETOUR, 0, 0, 3 * PER_DETOUR])

    soldier = View(board, SOLDIER, MIDDLE, GOAL).around("detour")
    assert soldier == pytest.approx([0, PER_DETOUR, 2 * PER_DETOUR, 0, 2 * PER_DETOUR, PER_DETOUR])


def test_a_direction_back_to_where_a_way_is_known_loses_nothing_and_stays_in_the_space() -> None:
    """Ways of more than 254 base hops count as none: behind such a place a way begins, much shorter than none."""
    width, rows = 99, []
    for y in range(13):  # a path to and fro, in seven rows
        open_row = "." * (width - y % 2)
        door = "." + "~" * (len(open_row) - 1) if y % 4 == 3 else "~" * (len(open_row) - 1) + "."
        rows.append(open_row if y % 2 == 0 else door)
    flat = "\n".join(" ".join("0" * len(row)) for row in rows)
    long = Terrain(make_map("\n".join(rows), flat), default_rules())
    eta = long.times_to(HopClass.VEHICLE, 0)
    behind = [c for c in np.flatnonzero(long.cells.passable) if eta[c] == TOO_FAR]
    edge = next(
        c for c in behind if any(eta[n] == TOO_FAR - 1 for n in long.cells[c].neighbour if n != NO_CELL)
    )

    view = View(long, TANK, int(edge), 0)

    assert view["goal: way"] == [MOST]
    assert min(view.around("detour")) == -MOST
    assert np.abs(view.state).max() <= BOUND


def test_without_ways_only_way_and_detours_are_missing(board: Terrain) -> None:
    full, bare = View(board, TANK, MIDDLE, GOAL), View(board, TANK, MIDDLE, GOAL, ways=False)

    changed = np.flatnonzero(full.state != bare.state)
    by_ways = [
        i for name, place in PLACES.items() if name.endswith(("way", "detour")) for i in range(200)[place]
    ]
    assert set(changed) <= set(by_ways)
    assert not bare.state[by_ways].any()
    assert full.state[by_ways].any()
    assert bare.mask.tolist() == full.mask.tolist()


@pytest.mark.parametrize(
    ("kind", "valid"),
    [
        (TANK, [W, SW, SE, NW]),  # neither into the lake nor up six levels
        (PieceType.CHARIOT, [W, SW, SE, NW]),
        (SOLDIER, [W, SW, SE, NE, NW]),
        (AEROCRAFT, [W, SW, SE, E, NE, NW]),
    ],
)
def test_the_mask_admits_the_hops_that_the_type_can_make(
    board: Terrain, kind: PieceType, valid: list[int]
) -> None:
    """Rule book, section 1: over five levels are too steep for vehicles only."""
    mask = View(board, kind, MIDDLE, GOAL).mask
    assert np.flatnonzero(mask[1:]).tolist() == valid


def test_staying_is_valid_in_the_right_place_alone(board: Terrain) -> None:
    """Elsewhere there is nothing to perform; in the right place it may still move on."""
    assert View(board, TANK, MIDDLE, GOAL).mask[STAY] == 0
    there = View(board, TANK, GOAL, GOAL).mask
    assert there[STAY] == 1
    assert there[1 + E] == 1


def test_a_piece_that_can_go_nowhere_may_stay() -> None:
    """Some answer is always valid."""
    island = Terrain(make_map("~~~\n~.\n~~~", "0 0 0\n0 0\n0 0 0"), default_rules())
    assert np.flatnonzero(View(island, TANK, 4, 8).mask).tolist() == [STAY]


def test_off_the_map_there_is_no_direction_and_nothing_to_tell(board: Terrain) -> None:
    for kind in PieceType:
        view = View(board, kind, 0, GOAL)
        assert np.flatnonzero(view.mask).tolist() == [1 + SE, 1 + E]
        for d in (W, SW, NE, NW):
            start = PLACES[f"neighbour {d}: climb"].start
            assert not view.state[start : start + 9].any()


def test_what_is_far_or_steep_is_cut_off() -> None:
    """A cliff of 20 levels is 4 by its scale, a goal without a way 32."""
    cliff = Terrain(make_map("...\n..\n...", "0 20 0\n0 0\n0 0 0"), default_rules())
    assert View(cliff, SOLDIER, 0, 8)["neighbour 3: climb"] == [MOST]
    assert View(cliff, SOLDIER, 1, 8)["neighbour 3: climb"] == [-MOST]
    assert not has_way(TANK, CellIndex(0), CellIndex(1), cliff.rules, cliff.cells, times_of(cliff))
    assert View(cliff, TANK, 0, 1)["goal: way"] == [MOST]


@pytest.mark.parametrize("seed", range(3))
def test_blue_on_the_mirrored_cell_of_the_mirrored_map_sees_the_same(seed: int) -> None:
    """Everything is in the camp's frame (architecture.md, section 3); the map itself is not symmetric."""
    hexmap = rough_map(seed)
    plain, turned = (Terrain(one, default_rules()) for one in (hexmap, hexmap.mirrored()))
    mirror = mirror_cells(hexmap.width, hexmap.height)
    rng = np.random.default_rng(seed)
    for cell, goal in rng.choice(np.flatnonzero(hexmap.passable), (40, 2)).tolist():
        for kind in PieceType:
            red = View(plain, kind, cell, goal)
            blue = View(turned, kind, int(mirror[cell]), int(mirror[goal]), camp=Camp.BLUE)
            assert red.state.tobytes() == blue.state.tobytes()
            assert red.mask.tolist() == blue.mask.tolist()


def slow_times(kind: PieceType, terrain: Terrain, start: int) -> dict[int, int]:
    """Ticks from one cell to every other, by the textbook's search along the hops."""
    best, heap = {start: 0}, [(0, start)]
    while heap:
        ticks, cell = heapq.heappop(heap)
        if ticks > best[cell]:
            continue
        for d, neighbour in enumerate(terrain.cells[cell].neighbour.tolist()):
            need = slow_hop(kind, terrain.cells, cell, d)
            if need and ticks + need < best.get(neighbour, 10**9):
                best[neighbour] = ticks + need
                heapq.heappush(heap, (ticks + need, neighbour))
    return best


def slow_hop(kind: PieceType, cells: Rows, cell: int, direction: int) -> int:
    """Ticks of a hop, by the table; 0: there is none."""
    if kind == AEROCRAFT:
        return 8 if cells[cell].neighbour[direction] != NO_CELL else 0
    hop_class = HopClass.SOLDIER if kind == SOLDIER else HopClass.VEHICLE
    return int(cells[cell].hop_ticks[hop_class, direction])


@pytest.mark.parametrize("kind", PieceType)
def test_detours_of_all_routes_equal_a_plain_search_and_are_0_exactly_on_fastest_ways(
    kind: PieceType,
) -> None:
    terrain = Terrain(rough_map(1), default_rules())
    base = {TANK: 20, PieceType.CHARIOT: 20, SOLDIER: 144, AEROCRAFT: 8}[kind]
    cells = np.flatnonzero(terrain.hexmap.passable).tolist()
    times = {cell: slow_times(kind, terrain, cell) for cell in cells}
    fastest = 0
    for start in cells:
        for goal in (goal for goal in cells if goal in times[start]):
            view = View(terrain, kind, start, goal)
            assert view["goal: way"][0] == pytest.approx(
                min(times[start][goal] / base * PER_HOP, MOST), abs=1e-4
            )
            for d, neighbour in enumerate(terrain.cells[start].neighbour.tolist()):
                hop = slow_hop(kind, terrain.cells, start, d)
                assert view.mask[1 + d] == (hop > 0)
                if hop == 0 or neighbour not in times:  # over a lake: an aerocraft alone
                    continue
                lost = hop + times[neighbour].get(goal, 10**6) - times[start][goal]
                detour = view[f"neighbour {d}: detour"][0]
                assert detour == pytest.approx(min(lost / base * PER_DETOUR, MOST), abs=1e-4)
                assert (detour == 0.0) == (lost == 0)
                fastest += lost == 0
    assert fastest > 100


def test_every_cell_with_a_way_has_a_direction_without_a_detour(board: Terrain) -> None:
    """What makes the smallest detour a complete answer."""
    for kind in PieceType:
        for cell in np.flatnonzero(board.hexmap.passable).tolist():
            if cell == GOAL or board.times_to(int(kind == SOLDIER), GOAL)[cell] == TOO_FAR:
                continue
            view = View(board, kind, cell, GOAL)
            detours = [view[f"neighbour {d}: detour"][0] for d in range(6) if view.mask[1 + d]]
            assert min(detours) == 0.0
            assert all(
                hop_from(kind, CellIndex(cell), d, board.rules, board.cells) > 0
                for d in np.flatnonzero(view.mask[1:]).tolist()
            )


SCRIPT = """
import hashlib, runpy, sys
import numpy as np
names = runpy.run_path(sys.argv[1])
digest = hashlib.sha256()
for seed in range(2):
    terrain = names["Terrain"](names["rough_map"](seed), names["default_rules"]())
    cells = np.flatnonzero(terrain.hexmap.passable).tolist()
    for k in range(60):
        kind, camp = names["PieceType"](k % 4), names["Camp"](k // 4 % 2)
        for part in names["observed"](terrain, kind, cells[k % len(cells)], cells[7 * k % len(cells)], camp=camp):
            digest.update(part.tobytes())
print(digest.hexdigest())
"""


def test_compiled_and_plain_python_agree_to_the_bit() -> None:
    digests = set()
    for disable_jit in ("0", "1"):
        env = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
        command = [sys.executable, "-c", SCRIPT, __file__]
        digests.add(subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout)

    assert len(digests) == 1
