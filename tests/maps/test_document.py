"""What a stranger's map or scenario leads to: one of our errors, at once."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from hexwar_sb3.errors import FileFormatError, HexWarError, UnknownNameError
from hexwar_sb3.maps.document import MAX_FILE_BYTES
from hexwar_sb3.maps.files import load_map, load_scenario, save_map
from hexwar_sb3.maps.scenario_file import scenario_document
from tests.maps.test_map_file import small_document
from tests.maps.test_scenario import small_document as small_scenario

LOADERS = {"map": (load_map, small_document), "scenario": (load_scenario, small_scenario)}


@pytest.mark.parametrize("kind", LOADERS)
def test_nothing_but_our_errors_comes_of_a_bad_file(kind: str, bad: Any, tmp_path: Path) -> None:
    load, document = LOADERS[kind]
    path, refused = tmp_path / "bad.json", 0
    for content in bad(document()):
        path.write_bytes(content)
        try:
            load(path)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 100


BIG = {
    "keys": lambda: json.dumps({f"k{n}": n for n in range(120_000)}),
    "keys that end alike": lambda: "{" + ",".join(['"a": 1'] * 200_000) + "}",
    "lists": lambda: "[" + "[]," * 600_000 + "[]]",
    "a long name": lambda: json.dumps({"name": "x" * (MAX_FILE_BYTES - 20)}),
    "controllable cells": lambda: json.dumps({**small_document(), "controllable": ["0202"] * 200_000}),
    "a long row": lambda: json.dumps({**small_document(), "terrain": ["." * 1_900_000, "...", "...."]}),
    "long numbers": lambda: "[" + "9" * 1_900_000 + "]",
}


@pytest.mark.parametrize("what", BIG)
def test_a_large_file_is_answered_in_two_seconds(what: str, tmp_path: Path) -> None:
    path = tmp_path / "big.json"
    path.write_text(BIG[what]())
    begun = process_time()
    for load in (load_map, load_scenario):
        with pytest.raises(FileFormatError) as caught:
            load(path)
        assert len(str(caught.value)) < 2_000
    assert process_time() - begun < 2.0


def fifo(path: Path) -> None:
    os.mkfifo(path)


NO_FILES: dict[str, Callable[[Path], object]] = {
    "a pipe": fifo,
    "a link to a device": lambda path: path.symlink_to("/dev/zero"),
    "a link to itself": lambda path: path.symlink_to(path),
    "a folder": lambda path: path.mkdir(),
    "nothing": Path.touch,
}


@pytest.mark.parametrize("what", NO_FILES)
def test_what_is_no_regular_file_is_refused_and_not_waited_for(what: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.json"
    NO_FILES[what](path)
    for load in (load_map, load_scenario):
        with pytest.raises(FileFormatError):
            load(path)


@pytest.mark.parametrize(
    "name", ["a\0b", "a\0b.json", "\ud800", "\ud800.json", "..", ".", "", "x" * 5_000, "/etc"]
)
def test_a_name_that_is_none_is_refused(name: str) -> None:
    for load in (load_map, load_scenario):
        with pytest.raises((HexWarError, OSError)):
            load(name)


@pytest.mark.parametrize(
    "name",
    [
        "..",
        ".",
        "../plain.json",
        "/etc/x.json",
        "a\\b.json",
        "..\\x.json",
        "C:x.json",
        "a/b.json",
        "a\0.json",
        "\ud800.json",
    ],
)
def test_a_scenario_names_a_map_of_its_own_folder_alone(name: str, tmp_path: Path) -> None:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps({**small_scenario(), "map": name}))
    with pytest.raises(FileFormatError):
        load_scenario(path)


def test_a_map_without_its_ending_is_answered_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "creek.scenario.json"
    path.write_text(json.dumps({**small_scenario(), "map": "creek"}))
    (tmp_path / "creek.map.json").write_text(json.dumps(small_scenario()["map"]))
    with pytest.raises(
        FileFormatError, match=r"found 'creek'; expected a built-in map .*; did you mean 'creek.map.json'"
    ):
        load_scenario(path)


def test_a_scenario_without_its_ending_is_answered_with_the_file_that_lies_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "creek.scenario.json").write_text(json.dumps(small_scenario()))
    with pytest.raises(
        UnknownNameError, match=r"unknown scenario 'creek'; did you mean 'creek\.scenario\.json'"
    ):
        load_scenario("creek")


def test_a_path_that_is_misspelt_is_answered_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "creek.scenario.json").write_text(json.dumps(small_scenario()))
    with pytest.raises(FileFormatError, match=r"No such file.*; did you mean 'creek\.scenario\.json'"):
        load_scenario(tmp_path / "crek.scenario.json")


def test_a_scenario_that_was_saved_says_the_same(tmp_path: Path) -> None:
    scenario = load_scenario("plain")
    save_map(scenario.hexmap, tmp_path / "creek.map.json")
    document = {**scenario_document(scenario), "map": "creek.map.json"}
    (tmp_path / "s.json").write_text(json.dumps(document))
    assert load_scenario(tmp_path / "s.json").hash == scenario.hash
