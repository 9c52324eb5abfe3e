"""Map files: what is written reads back; what is broken is refused with its place."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import MapFileError, UnknownNameError
from hexwar_sb3.maps.files import builtin_names, load_map, map_from_document, save_map
from hexwar_sb3.maps.map_file import map_document
from hexwar_sb3.maps.scenario import Scenario

Edit = Callable[[dict[str, Any]], Any]


def small_document() -> dict[str, Any]:
    return {
        "format": "hexwar-map",
        "version": 1,
        "name": "small",
        "width": 4,
        "height": 3,
        "grade_m": 10,
        "controllable": ["0202"],
        "terrain": ["..f=", ".m~", "x^.."],
        "levels": ["0 1 2 3", "4 5 6", "7 8 9 10"],
    }


def set_in(*path: Any, to: Any) -> Edit:
    def edit(document: dict[str, Any]) -> None:
        place: Any = document
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = to

    return edit


def test_a_map_file_says_what_it_means() -> None:
    hexmap = map_from_document(small_document(), "small")
    assert (hexmap.width, hexmap.height, hexmap.n_cells) == (4, 3, 12)
    assert hexmap.elev_m.tolist() == [[0, 10, 20, 30], [40, 50, 60, 0], [70, 80, 90, 100]]
    assert hexmap.concealed.tolist() == [[0, 0, 1, 0], [0, 0, 0, 0], [0, 1, 0, 0]]
    assert hexmap.passable.tolist() == [[1, 1, 1, 1], [1, 1, 0, 0], [0, 0, 1, 1]]
    assert hexmap.paved.tolist() == [[0, 0, 0, 1], [0, 0, 0, 0], [1, 0, 0, 0]]
    assert hexmap.slushy.tolist() == [[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]]
    assert hexmap.controllable.ravel().nonzero()[0].tolist() == [5]


def test_builtin_maps_read_back_as_written(scenario: Scenario, tmp_path: Path) -> None:
    path = tmp_path / "copy.json"
    save_map(scenario.hexmap, path)
    copy = load_map(path)
    assert map_document(copy) == map_document(scenario.hexmap)
    assert copy.hash == scenario.hexmap.hash


@pytest.mark.parametrize("seed", range(5))
def test_rough_maps_read_back_as_written(rough_board: Any, seed: int) -> None:
    hexmap = rough_board(seed)
    copy = map_from_document(json.loads(json.dumps(map_document(hexmap))), "copy")
    assert map_document(copy) == map_document(hexmap)


def test_builtin_maps_are_three() -> None:
    assert builtin_names() == ["assault", "battalion", "hills", "paddy", "plain", "skirmish"]


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="unknown map 'plian'; did you mean 'plain'"):
        load_map("plian")


BROKEN: dict[str, tuple[Edit, str, str]] = {
    "missing key": (lambda d: d.pop("terrain"), "file", "no 'terrain'"),
    "unknown key": (set_in("colour", to=1), "file", 'the key "colour"'),
    "other format": (
        set_in("format", to="hexwar-scenario"),
        "format",
        '"hexwar-scenario"; expected one of hexwar-map',
    ),
    "newer version": (set_in("version", to=2), "version", "2; expected a whole number from 1 to 1"),
    "version as text": (set_in("version", to="1"), "version", '"1"'),
    "true as number": (set_in("version", to=True), "version", "true"),
    "name of spaces": (set_in("name", to=""), "name", '""; expected a text of 1 to 80'),
    "name with a control character": (set_in("name", to="a\x1b[31m"), "name", "expected a text"),
    "too wide": (set_in("width", to=251), "width", "251; expected a whole number from 3 to 250"),
    "too low": (set_in("height", to=2), "height", "2; expected a whole number from 3 to 250"),
    "width as fraction": (set_in("width", to=4.0), "width", "4.0"),
    "grade 0": (set_in("grade_m", to=0), "grade_m", "0; expected a whole number from 1 to 100"),
    "row too short": (set_in("terrain", 2, to="..."), "terrain[2]", "3 cells; expected 4"),
    "odd row too long": (set_in("terrain", 1, to="...."), "terrain[1]", "4 cells; expected 3"),
    "row missing": (lambda d: d["terrain"].pop(), "terrain", "2 entries; expected 3"),
    "row no text": (set_in("terrain", 0, to=[1]), "terrain[0]", "[1]; expected a text"),
    "rows no list": (set_in("terrain", to="...."), "terrain", "expected a list"),
    "unknown symbol": (
        set_in("terrain", 0, to="..?."),
        "terrain[0], character 3",
        '"?"; expected one of . f m',
    ),
    "levels short": (set_in("levels", 0, to="0 1 2"), "levels[0]", "3 cells; expected 4"),
    "level no number": (
        set_in("levels", 1, to="4 x 6"),
        "levels[1], number 2",
        '"x"; expected a level from 0',
    ),
    "level negative": (set_in("levels", 1, to="4 -5 6"), "levels[1], number 2", '"-5"'),
    "level too high": (
        set_in("levels", 1, to="4 901 6"),
        "levels[1], number 2",
        '"901"; expected a level from 0 to 900',
    ),
    "level of a thousand digits": (
        set_in("levels", 1, to=f"4 {'9' * 1000} 6"),
        "levels[1], number 2",
        '"999',
    ),
    "point off the map": (
        set_in("controllable", to=["0502"]),
        "controllable[0]",
        '"0502"; expected a cell of the map',
    ),
    "point on void": (set_in("controllable", to=["0402"]), "controllable[0]", '"0402"'),
    "point no name": (set_in("controllable", to=["ab"]), "controllable[0]", '"ab"'),
    "seed negative": (set_in("seed", to=-1), "seed", "-1; expected a whole number from 0"),
    "edited but not its hash": (
        set_in("hash", to="0123456789abcdef"),
        "hash",
        '"0123456789abcdef"; expected "',
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_map_names_place_found_and_expected(case: str, tmp_path: Path) -> None:
    edit, place, text = BROKEN[case]
    document = small_document()
    edit(document)
    path = tmp_path / "broken.map.json"
    path.write_text(json.dumps(document))
    with pytest.raises(MapFileError) as caught:
        load_map(path)
    assert caught.value.place == place
    assert str(caught.value).startswith(f"{path}: {place}: found ")
    assert text in str(caught.value)


FILES = {
    "not JSON": (b"{ 'format'", "file, line 1, column 3", "expected an object as JSON"),
    "empty": (b"", "file, line 1, column 1", "expected an object as JSON"),
    "cut off": (
        json.dumps(small_document()).encode()[:90],
        "file, line 1, column",
        "expected an object as JSON",
    ),
    "a list": (b"[]", "file", "[]; expected an object"),
    "not UTF-8": (b"\xff\xfe{}", "file", "expected an object as JSON in UTF-8"),
    "a key twice": (b'{"width": 3, "width": 4}', "file", "the key 'width' twice"),
    "nested without end": (b"[" * 200_000, "file", "expected an object as JSON"),
    "a number of 10,000 digits": (b'{"width": ' + b"9" * 10_000 + b"}", "file", "expected an object as JSON"),
    "3 MB of zeros": (bytes(3_000_000), "file", "more than 2000000 bytes"),
}


@pytest.mark.parametrize("case", FILES)
def test_a_file_that_is_no_map_is_refused(case: str, tmp_path: Path) -> None:
    content, place, text = FILES[case]
    path = tmp_path / "bad.json"
    path.write_bytes(content)
    with pytest.raises(MapFileError) as caught:
        load_map(path)
    assert caught.value.place.startswith(place)
    assert text in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match="No such file or directory; expected a readable file"):
        load_map(tmp_path / "nowhere.json")


def test_a_huge_file_is_not_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "huge.json"
    with path.open("wb") as file:
        file.truncate(10**12)  # sparse: a terabyte of zeros on no disk
    with pytest.raises(MapFileError, match="more than 2000000 bytes; expected at most"):
        load_map(path)


def test_a_failed_save_leaves_the_old_file(
    board: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "kept.json"
    path.write_text("old")
    monkeypatch.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        save_map(board("...\n..\n..."), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
