"""Starts (rules.md, section 1): the built-in ones, and everything a scenario file may get wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine import records
from hexwar_sb3.errors import ConfigError, MapFileError, ScenarioFileError, UnknownNameError
from hexwar_sb3.maps import scenario as limits
from hexwar_sb3.maps.files import load_scenario, save_scenario, scenario_from_document
from hexwar_sb3.maps.geometry import mirror_cells
from hexwar_sb3.maps.scenario import PieceStart, Scenario
from hexwar_sb3.maps.scenario_file import scenario_document
from hexwar_sb3.rules.enums import Camp, PieceType

Edit = Callable[[dict[str, Any]], Any]


def test_both_camps_start_with_the_seven_pieces_of_the_rule_book(scenario: Scenario) -> None:
    name = scenario.hexmap.cell_name
    red = {p.name: (name(p.cell), p.home, p.aboard) for p in scenario.pieces if p.camp == Camp.RED}
    assert red == {
        "tank0": ("1135", None, False),
        "tank1": ("1145", None, False),
        "chariot0": ("1037", None, False),
        "chariot1": ("1043", None, False),
        "soldier0": ("1037", "chariot0", True),
        "soldier1": ("1043", "chariot1", True),
        "aerocraft0": ("0941", None, False),
    }


def test_blue_starts_in_the_mirror(scenario: Scenario) -> None:
    mirror = mirror_cells(scenario.hexmap.width, scenario.hexmap.height)
    red, blue = scenario.pieces[:7], scenario.pieces[7:]
    for piece, image in zip(red, blue, strict=True):
        assert image == replace(piece, camp=Camp.BLUE, cell=mirror[piece.cell])


def test_the_main_point_is_worth_80_and_the_secondary_50(scenario: Scenario) -> None:
    name = scenario.hexmap.cell_name
    points = [(p.name, name(p.cell), p.value) for p in scenario.points]
    assert points == [("main", "3635", 80), ("secondary", "3647", 50)]
    assert scenario.game_ticks == 1800
    assert not scenario.net_score


def test_a_name_and_a_seed_make_a_scenario_of_the_same_plan() -> None:
    hills = load_scenario("hills")
    assert load_scenario(f"hills@{hills.hexmap.seed}").hash == hills.hash
    other = load_scenario("hills@7")
    assert (other.name, other.hexmap.seed, other.pieces) == ("hills@7", 7, hills.pieces)
    assert other.hexmap.hash != hills.hexmap.hash
    with pytest.raises(UnknownNameError, match="unknown map 'hill'; did you mean 'hills'"):
        load_scenario("hill@7")


def test_scenarios_read_back_as_written(scenario: Scenario, tmp_path: Path) -> None:
    path = tmp_path / "copy.json"
    for map_name in (None, scenario.name):
        save_scenario(scenario, path, map_name)
        copy = load_scenario(path)
        assert scenario_document(copy) == scenario_document(scenario)
        assert copy.hash == scenario.hash


def test_a_scenario_finds_its_map_in_its_own_folder(scenario: Scenario, tmp_path: Path) -> None:
    document = scenario_document(scenario)
    (tmp_path / "own.json").write_text(json.dumps(document["map"]))
    (tmp_path / "scenario.json").write_text(json.dumps(document | {"map": "own.json"}))
    assert load_scenario(tmp_path / "scenario.json").hash == scenario.hash


def test_limits_are_those_of_the_records() -> None:
    assert limits.MAX_SIDE_PIECES == records.MAX_SIDE
    assert 2 * limits.MAX_SIDE_PIECES == records.MAX_PIECES
    assert limits.MAX_CONTROL_POINTS == records.MAX_POINTS
    assert limits.MAX_GAME_TICKS < records.NEVER


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="unknown scenario 'hill'; did you mean 'hills'"):
        load_scenario("hill")


def test_a_scenario_made_in_code_is_checked_too(scenario: Scenario) -> None:
    with pytest.raises(
        ConfigError, match="piece red:tank0: found cell index 999999; expected a playable cell"
    ):
        replace(scenario, pieces=(replace(scenario.pieces[0], cell=999_999),))


def test_blue_before_red_is_refused(scenario: Scenario) -> None:
    with pytest.raises(ConfigError, match="red's pieces first"):
        replace(scenario, pieces=scenario.pieces[::-1])


def test_a_green_piece_is_refused(scenario: Scenario) -> None:
    piece = PieceStart(camp=Camp.GREEN, name="tank0", kind=PieceType.TANK, cell=0)
    with pytest.raises(ConfigError, match="camp green; expected red or blue"):
        replace(scenario, pieces=(piece,))


def small_document() -> dict[str, Any]:
    return {
        "format": "hexwar-scenario",
        "version": 1,
        "name": "duel",
        "game_ticks": 600,
        "points": [{"name": "bridge", "cell": "0302", "value": 30}],
        "pieces": [
            {"camp": "red", "name": "chariot0", "kind": "chariot", "cell": "0101"},
            {
                "camp": "red",
                "name": "soldier0",
                "kind": "soldier",
                "cell": "0101",
                "home": "chariot0",
                "aboard": True,
            },
            {"camp": "blue", "name": "tank0", "kind": "tank", "cell": "0501"},
        ],
        "map": {
            "format": "hexwar-map",
            "version": 1,
            "name": "small",
            "width": 5,
            "height": 3,
            "grade_m": 10,
            "controllable": ["0302"],
            "terrain": [".....", "~..m", "....."],
            "levels": ["0 0 0 0 0", "0 0 0 0", "0 0 0 0 0"],
        },
    }


def test_a_scenario_file_says_what_it_means() -> None:
    scenario = scenario_from_document(small_document(), "duel")
    assert [str(piece) for piece in scenario.pieces] == ["red:chariot0", "red:soldier0", "blue:tank0"]
    assert scenario.pieces[1].aboard
    assert scenario.points[0].cell == 7
    assert scenario.game_ticks == 600


def test_blue_pieces_may_stand_first_in_a_file() -> None:
    document = small_document()
    document["pieces"].reverse()
    assert [p.camp for p in scenario_from_document(document, "duel").pieces] == [0, 0, 1]


def piece(i: int, **changes: Any) -> Edit:
    return lambda d: d["pieces"][i].update(changes)


def point(**changes: Any) -> Edit:
    return lambda d: d["points"][0].update(changes)


def top(**changes: Any) -> Edit:
    return lambda d: d.update(changes)


def crowd(count: int, kind: str = "tank") -> Edit:
    entry = {"camp": "blue", "kind": kind, "cell": "0501"}
    return lambda d: d["pieces"].extend({**entry, "name": f"{kind}{n}"} for n in range(1, count))


def two_of_one_name(document: dict[str, Any]) -> None:
    document["pieces"].append(dict(document["pieces"][2]))


def two_aboard(document: dict[str, Any]) -> None:
    document["pieces"].append({**document["pieces"][1], "name": "soldier1"})


BROKEN: dict[str, tuple[Edit, str, str]] = {
    "missing key": (lambda d: d.pop("points"), "file", "no 'points'"),
    "unknown key": (top(fog=True), "file", 'the key "fog"'),
    "a map file": (top(format="hexwar-map"), "format", "expected one of hexwar-scenario"),
    "newer version": (top(version=9), "version", "9; expected a whole number"),
    "endless game": (top(game_ticks=10**6), "game_ticks", "1000000; expected a whole number from 1 to 30000"),
    "net_score as number": (top(net_score=1), "net_score", "1; expected true or false"),
    "edited but not its hash": (top(hash="abc"), "hash", '"abc"; expected "'),
    "unknown map": (top(map="plian"), "map", "or a .json file beside the scenario; did you mean 'plain'?"),
    "map elsewhere": (top(map="../../etc/x.json"), "map", "expected a file in the scenario's own folder"),
    "pieces no list": (top(pieces={}), "pieces", "{}; expected a list"),
    "one piece": (
        lambda d: d["pieces"].__delitem__(slice(1, None)),
        "pieces",
        "1 entries; expected 2 to 128",
    ),
    "one camp": (lambda d: d["pieces"].pop(), "pieces", "pieces of one camp only"),
    "piece no object": (lambda d: d["pieces"].append(3), "pieces[3]", "3; expected an object"),
    "piece without cell": (lambda d: d["pieces"][0].pop("cell"), "pieces[0]", "no 'cell'"),
    "piece with blood": (piece(0, blood=3), "pieces[0]", 'the key "blood"'),
    "green piece": (piece(0, camp="green"), "pieces[0].camp", '"green"; expected one of red, blue'),
    "unknown kind": (piece(0, kind="truck"), "pieces[0].kind", '"truck"; expected one of tank, chariot'),
    "name of another kind": (
        piece(2, name="chariot0"),
        "piece blue:chariot0",
        "expected 'tank' and a number",
    ),
    "cell off the map": (piece(2, cell="0901"), "pieces[2].cell", '"0901"; expected a cell of the map'),
    "start on void": (piece(2, cell="0502"), "pieces[2].cell", '"0502"'),
    "start in a lake": (piece(2, cell="0102"), "piece blue:tank0", "impassable cell 0102"),
    "start in a marsh": (piece(2, cell="0402"), "piece blue:tank0", "slushy cell 0402; expected a dry start"),
    "both camps in one cell": (piece(2, cell="0101"), "cell 0101", "ground pieces of both camps"),
    "five in one cell": (crowd(5), "cell 0501", "5 ground pieces; expected at most 4"),
    "sixty-five of a camp": (crowd(65, "aerocraft"), "pieces", "65 of blue; expected at most 64"),
    "two of one name": (two_of_one_name, "piece blue:tank0", "2 of that name; expected one"),
    "two aboard": (two_aboard, "piece red:chariot0", "2 soldiers aboard; expected at most one"),
    "home of nobody": (
        piece(1, home="chariot7"),
        "piece red:soldier0",
        "home 'chariot7'; expected a chariot of its camp",
    ),
    "home of the other camp": (
        piece(1, home="tank0"),
        "piece red:soldier0",
        "expected a chariot of its camp",
    ),
    "tank with a home": (piece(2, home="chariot0"), "piece blue:tank0", "expected a home for soldiers only"),
    "aboard but elsewhere": (
        piece(1, cell="0201"),
        "piece red:soldier0",
        "cell 0201; expected its chariot's cell",
    ),
    "aboard of nothing": (
        lambda d: d["pieces"][1].pop("home"),
        "piece red:soldier0",
        "aboard without a home",
    ),
    "aboard as text": (piece(1, aboard="yes"), "pieces[1].aboard", '"yes"; expected true or false'),
    "point off the map": (point(cell="0109"), "points[0].cell", '"0109"'),
    "point on another cell": (
        point(cell="0202"),
        "point bridge",
        "cell 0202; expected a controllable, passable cell",
    ),
    "worthless point": (point(value=0), "points[0].value", "0; expected a whole number from 1 to 1000"),
    "one point twice": (lambda d: d["points"].append(d["points"][0]), "points", "expected all different"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_scenario_names_place_found_and_expected(case: str, tmp_path: Path) -> None:
    edit, place, text = BROKEN[case]
    document = small_document()
    edit(document)
    path = tmp_path / "broken.scenario.json"
    path.write_text(json.dumps(document))
    with pytest.raises(ScenarioFileError) as caught:
        load_scenario(path)
    assert caught.value.place == place
    assert str(caught.value).startswith(f"{path}: {place}: found ")
    assert text in str(caught.value)


def test_a_broken_map_inside_is_a_map_error_with_its_place(tmp_path: Path) -> None:
    document = small_document()
    document["map"]["terrain"][1] = "~.m"
    path = tmp_path / "broken.scenario.json"
    path.write_text(json.dumps(document))
    with pytest.raises(MapFileError, match=r"map\.terrain\[1\]: found 3 cells; expected 4"):
        load_scenario(path)
