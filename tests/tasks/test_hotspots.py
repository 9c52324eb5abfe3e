"""Hot spots from replays (III-C, "Preprocessing"; assumption A30)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import GetOff, Move
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import ConfigError, FileFormatError, ReplayFileError
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.ruleset import default_rules
from hexwar_sb3.tasks.hotspots import (
    Ints,
    VisitCount,
    hot_spots,
    hull_corners,
    is_mirrored,
    ranked,
    static_hot_spots,
    walls,
)
from hexwar_sb3.tasks.spots import overlooking
from hexwar_sb3.tasks.spots_file import HotSpots, read_spots

BOARD = """
    map   plain-15x9
    {extra}
    point main 0805 80
    red   tank 0203
    red   chariot 0205
    red   soldier aboard chariot0
    red   aerocraft 0204
    blue  tank 1403
    blue  chariot 1405
    blue  soldier aboard chariot0
    blue  aerocraft 1304
"""


def board(extra: str = "") -> Game:
    return Game.from_text(BOARD.format(extra=extra))


def played(extra: str = "") -> Game:
    """A game whose stays are counted by hand: tanks hop in 20 ticks, a stop takes 75."""
    game = board(extra)
    game.submit(
        "red", [Move("tank0", ["E", "E"]), Move("chariot0", ["E"]), Move("aerocraft0", ["E"])], strict=False
    )
    game.submit("blue", [Move("tank0", ["W"])], strict=False)
    game.advance(115)  # tank0 came to 0403 at 40 and stood there for 75
    game.submit("red", [Move("tank0", ["E"]), GetOff("chariot0", "soldier0")], strict=False)
    game.advance(20 + 74)  # in 0503 at 135, and away one tick too early for a visit
    game.submit("red", [Move("tank0", ["W"])], strict=False)
    game.advance(200)  # in 0403 again, to the end
    return game


def named(game: Game, visits: Ints) -> dict[str, int]:
    name = game.world.scenario.hexmap.cell_name
    return {name(int(cell)): int(visits[cell]) for cell in np.flatnonzero(visits)}


def counted(*games: Game) -> VisitCount:
    count = VisitCount()
    for game in games:
        count.add(Replay.of(game))
    return count


def visits_at(world: World, **visits: int) -> Ints:
    """Visits by name: `c0403=2`."""
    counts = np.zeros(world.cells.size, np.int64)
    for name, number in visits.items():
        counts[world.scenario.hexmap.parse_cell(name[1:])] = number
    return counts


def test_a_visit_is_a_stay_of_a_ground_piece_whoever_rode_or_passed() -> None:
    """Soldier and chariot both stay in 0305; 0303 was passed, 0503 left too early; no start counts."""
    game = played("cell 1509 elev 10")  # no mirror image: camps apart

    red, blue = counted(game).visits

    assert named(game, red) == {"0403": 2, "0305": 2}
    assert named(game, blue) == {"1303": 1}


def test_a_long_stay_is_one_visit_and_games_add_up() -> None:
    game = played("cell 1509 elev 10")
    longer = played("cell 1509 elev 10")
    longer.advance(500)

    count = counted(game, longer)

    assert named(game, count.visits[Camp.RED]) == {"0403": 4, "0305": 4}
    assert count.replays == 2


def test_on_a_mirrored_start_each_camp_has_both_camps_visits_in_its_frame() -> None:
    """Blue's 1303 is red's 0303."""
    game = played()

    red, blue = counted(game).visits

    assert named(game, red) == {"0403": 2, "0305": 2, "0303": 1}
    assert named(game, blue) == {"1203": 2, "1305": 2, "1303": 1}


@pytest.mark.parametrize(
    "extra", ["cell 0101 elev 10", "cell 0101 concealed", "point second 0505 50", "red tank 0307"]
)
def test_a_start_with_a_better_side_is_not_mirrored(extra: str) -> None:
    assert is_mirrored(board().world.scenario)
    assert not is_mirrored(board(extra).world.scenario)


def test_a_replay_of_another_map_is_refused(tmp_path: Path) -> None:
    Replay.of(board("cell 0808 slushy")).save(tmp_path / "other.hwr")
    count = counted(board())

    with pytest.raises(
        ReplayFileError, match=r'other\.hwr: head\.scenario\.map: found "plain-15x9" \(.*the map of'
    ):
        count.add(Replay.load(tmp_path / "other.hwr"))
    assert count.replays == 1


def test_one_camps_own_record_is_refused() -> None:
    with pytest.raises(ReplayFileError, match="head: found the record of red only; expected a whole replay"):
        VisitCount().add(Replay.of(board()).for_camp("red"))


def test_an_event_that_cannot_be_says_its_line() -> None:
    replay = Replay.of(played())
    lines = [line | ({"cell": "9999"} if line.get("kind") == "off" else {}) for line in replay.lines]

    with pytest.raises(ReplayFileError, match=r'line [0-9]+\.cell: found "9999"'):
        VisitCount().add(Replay(tuple(lines)))


def test_spots_are_the_most_visited_cells_apart_from_points_and_each_other() -> None:
    """0705 lies beside the point 0805, 0504 three cells from 0303; 0207 cannot be entered."""
    world = board("cell 0207 1407 blocked").world
    visits = visits_at(world, c0705=9, c0504=4, c0303=5, c0207=7, c0703=3, c0309=3)

    names = [world.scenario.hexmap.cell_name(cell) for cell in ranked(world, Camp.RED, visits)]

    assert names == ["0303", "0703", "0309"]


def test_ties_go_to_the_same_cell_in_each_camps_frame() -> None:
    world = board().world
    red = visits_at(world, c0309=2, c0709=2, c0303=1)

    frames = ranked(world, Camp.RED, red), ranked(world, Camp.BLUE, red[world.cells.mirror])

    assert [int(world.cells[cell].mirror) for cell in frames[0]] == frames[1]


def test_too_few_visited_cells_for_k_are_refused() -> None:
    world = board().world
    visits = np.stack([visits_at(world, c0403=1), visits_at(world, c1203=1)])

    with pytest.raises(ConfigError, match="k is 2, but only 1 cells were visited: count more games"):
        hot_spots(world, visits, 2, source="a test")
    assert [len(camp.cells) for camp in hot_spots(world, visits, source="a test").camps] == [1, 1]
    with pytest.raises(ConfigError, match="k is 1, but only 0 cells were visited"):
        hot_spots(world, np.zeros_like(visits), source="a test")


@pytest.mark.parametrize(
    ("cells", "corners"),
    [
        (["0303", "0503", "0703", "0307", "0707", "0505"], ["0307", "0707", "0703", "0303"]),
        (["0303", "0305", "0503", "0504", "0505"], ["0305", "0505", "0504", "0503", "0303"]),
        (["0303", "0303", "0505"], ["0303", "0505"]),
    ],
)
def test_the_hull_has_the_outer_cells_as_corners_and_nothing_on_its_sides(
    cells: list[str], corners: list[str]
) -> None:
    """Even rows lie half a cell farther east, so 0504 stands out."""
    world = board().world
    hexmap = world.scenario.hexmap

    hull = hull_corners(world, [hexmap.parse_cell(name) for name in cells])

    assert [hexmap.cell_name(cell) for cell in hull] == corners


def test_the_hull_encloses_every_spot_and_control_point() -> None:
    world = Game("plain").world
    spots = static_hot_spots(world)
    y = -world.cells.y * np.sqrt(3) / 2
    x = world.cells.x + world.cells.y % 2 / 2

    for own in spots.camps:
        inside = [*own.cells, *(point.cell for point in world.scenario.points)]
        for a, b in zip(own.hull, (*own.hull[1:], own.hull[0]), strict=True):
            left = (x[b] - x[a]) * (y[inside] - y[a]) - (y[b] - y[a]) * (x[inside] - x[a])
            assert left.min() > -1e-9


def test_walls_stand_where_a_climb_is_too_steep_for_vehicles() -> None:
    """All six sides of a lone height of one level more than a vehicle climbs; none of one level less."""
    level_m = 10
    most_m = default_rules().number("max_climb") * level_m
    high = board(f"cell 0303 elev {most_m + level_m}").world
    names = high.scenario.hexmap.cell_name

    assert [(names(a), names(b)) for a, b in walls(high)] == [
        *(("0202", "0303"), ("0302", "0303"), ("0203", "0303")),
        *(("0303", "0403"), ("0303", "0204"), ("0303", "0304")),
    ]
    assert walls(board(f"cell 0303 elev {most_m}").world) == []


def test_a_road_leads_through_a_wall() -> None:
    high = default_rules().number("max_climb") * 20
    world = board(f"cell 0303 elev {high}\n    cell 0303 0403 paved").world

    assert len(walls(world)) == 5


@pytest.fixture
def spots() -> HotSpots:
    count = counted(played("cell 0303 elev 200"))
    return hot_spots(count.world, count.visits, 1, source="one game")


def test_hot_spots_come_back_from_their_file(spots: HotSpots, tmp_path: Path) -> None:
    spots.save(tmp_path / "spots.json")

    again = read_spots(tmp_path / "spots.json", spots.hexmap)

    assert again == spots
    assert list(again.camps[Camp.RED].visits) == list(spots.camps[Camp.RED].visits)
    assert again.walls


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": 1}, "schema: found 1; expected a whole number from 2 to 2"),
        ({"map_hash": "0"}, r'map_hash: found "0"; expected "[0-9a-f]{16}", the map plain-15x9'),
        ({"k": 9}, "k: found 9; expected a whole number from 0 to 1"),
        ({"walls": ["0101"]}, "walls: found "),
        ({"walls": ["0101-0301"]}, 'walls: found "0101-0301"; expected two neighbours'),
        ({"walls": ["0101-0101"]}, "expected two neighbours"),
        ({"more": 1}, 'file: found the key "more"'),
        ({"red": {"cells": ["0403", "0403"], "hull": [], "visits": {}}}, 'red.cells: found "0403" twice'),
        ({"red": {"cells": ["0403"], "hull": [], "visits": {"0403": 0}}}, "red.visits.0403: found 0"),
        ({"blue": {"cells": []}}, "blue: found no 'hull'"),
    ],
)
def test_a_broken_file_says_where_and_what(
    spots: HotSpots, tmp_path: Path, change: dict[str, object], message: str
) -> None:
    path = tmp_path / "spots.json"
    path.write_text(json.dumps(spots.document() | change), encoding="utf-8")

    with pytest.raises(FileFormatError, match=message):
        read_spots(path, spots.hexmap)


def test_a_cut_off_file_is_refused(spots: HotSpots, tmp_path: Path) -> None:
    path = tmp_path / "spots.json"
    spots.save(path)
    path.write_bytes(path.read_bytes()[:-9])

    with pytest.raises(
        FileFormatError,
        match=r"spots\.json: file, line [0-9]+, column [0-9]+: found .*; expected an object as JSON",
    ):
        read_spots(path, spots.hexmap)


def test_control_points_take_turns_with_cells_that_overlook_them() -> None:
    """A busy place behind the front comes after the cells of the battle, however often it was visited."""
    world = load_world("plain")
    points = [int(point.cell) for point in world.scenario.points]
    near = [np.flatnonzero(overlooking(world, point) & (world.cells.passable == 1)) for point in points]
    far = int(next(piece.cell for piece in world.scenario.pieces if piece.name == "tank0")) + 3
    visits = np.zeros(world.cells.size, np.int64)
    visits[near[0]], visits[near[1]], visits[far] = 5, 2, 1_000

    first = ranked(world, Camp.RED, visits)[:4]

    assert all(overlooking(world, points[k % 2])[cell] for k, cell in enumerate(first))
    assert far not in first
