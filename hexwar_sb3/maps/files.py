"""Maps and scenarios by name or path. Nothing is half loaded; a file is replaced whole or not at all."""

from __future__ import annotations

import difflib
import json
import re
from dataclasses import replace
from itertools import islice
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from hexwar_sb3.errors import MapFileError, ScenarioFileError, UnknownNameError, shortened
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.document import Document
from hexwar_sb3.maps.generator import generate, standard_scenario
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import map_document, map_from
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.scenario_file import scenario_document, scenario_from
from hexwar_sb3.maps.spec import MAP_SPECS

BUILTIN = Path(__file__).parent / "builtin"
_LIKE = re.compile(r"(\w+)@([0-9]{1,9})")  # "hills@7": a map like "hills" under seed 7

_LOOKED_AT = 1_000  # files of a folder, for a hint


class UnknownFileError(UnknownNameError):
    """A name of nothing that is built in, though a file of that name lies where one would look for it."""

    def __init__(self, kind: str, name: str, known: list[str], file: str) -> None:
        super().__init__(kind, name, known)
        self.parts = (*self.parts, file)  # type: ignore[assignment]  # what `__reduce__` gives
        self.message = f"{self.says.format(kind=kind, name=shortened(name))}; did you mean {file!r}?"


def builtin_names() -> list[str]:
    """Names of the built-in maps; each has a scenario of the same name."""
    return sorted(path.name.removesuffix(".map.json") for path in BUILTIN.glob("*.map.json"))


def load_map(name_or_path: str | Path) -> HexMap:
    """A built-in map by its name, one like it by `NAME@SEED`, or a map file by its path, which ends in ".json".

    Raises:
        UnknownNameError: no built-in map has this name.
        MapFileError: the file cannot be used; it says where and why.
    """
    like = _LIKE.fullmatch(str(name_or_path))
    if like is not None:
        return _map_like(*like.groups())
    path = _find("map", name_or_path)
    return map_from(Document.read(path, MapFileError, _readable(path)))


def load_scenario(name_or_path: str | Path) -> Scenario:
    """A built-in scenario by its name, one like it by `NAME@SEED`, or a scenario file by its path ending in ".json".

    The map that a file names is a built-in one or a file in the same folder.

    Raises:
        UnknownNameError: no built-in scenario has this name.
        ScenarioFileError: the file cannot be used; it says where and why.
        MapFileError: the same of its map.

    Example:
        >>> load_scenario("hills@7").hexmap.is_symmetric()
        True
    """
    like = _LIKE.fullmatch(str(name_or_path))
    if like is not None:
        return standard_scenario(load_map(name_or_path), MAP_SPECS[like[1]].start)
    path = _find("scenario", name_or_path)
    return _scenario_in(Document.read(path, ScenarioFileError, _readable(path)), path.parent)


def map_from_document(data: object, source: str) -> HexMap:
    """The map that `map_document` described; `source` names it in messages."""
    return map_from(Document(data, source, MapFileError))


def scenario_from_document(data: object, source: str) -> Scenario:
    """The scenario that `scenario_document` described; `source` names it in messages."""
    return _scenario_in(Document(data, source, ScenarioFileError), BUILTIN)


def save_map(hexmap: HexMap, path: str | Path) -> None:
    """Write a map file."""
    _write(Path(path), map_document(hexmap))


def save_scenario(scenario: Scenario, path: str | Path, map_name: str | None = None) -> None:
    """Write a scenario file that names its map, or holds it if `map_name` is None."""
    _write(Path(path), scenario_document(scenario, map_name))


def _map_like(name: str, seed: str) -> HexMap:
    """A map like a built-in one, under another seed."""
    if name not in MAP_SPECS:
        raise UnknownNameError("map", name, MAP_SPECS)
    return generate(replace(MAP_SPECS[name], name=f"{name}@{int(seed)}", seed=int(seed)))


def _find(kind: str, name_or_path: str | Path) -> Path:
    if isinstance(name_or_path, Path) or name_or_path.endswith(".json"):
        return Path(name_or_path)
    if name_or_path in builtin_names():
        return BUILTIN / f"{name_or_path}.{kind}.json"
    file = _file_called(kind, name_or_path, Path())
    if file is not None:
        raise UnknownFileError(kind, name_or_path, builtin_names(), file)
    raise UnknownNameError(kind, name_or_path, builtin_names())


def _file_called(kind: str, name: str, folder: Path) -> str | None:
    """File of a folder that a name without its ending may mean."""
    return next((file for file in (f"{name}.{kind}.json", f"{name}.json") if file in _files(folder)), None)


def _readable(path: Path) -> str:
    """What is expected of a file: that it is there; with the nearest one that is."""
    close = [] if path.exists() else difflib.get_close_matches(path.name[:255], _files(path.parent), n=1)
    return f"a readable file; did you mean {close[0]!r}?" if close else "a readable file"


def _files(folder: Path) -> list[str]:
    try:
        return [path.name for path in islice(folder.iterdir(), _LOOKED_AT) if path.name.endswith(".json")]
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return []


def _scenario_in(document: Document, folder: Path) -> Scenario:
    def find_map(name: str) -> HexMap:
        if {PurePosixPath(name).name, PureWindowsPath(name).name} != {name} or name == "..":
            document.fail(document.at("map"), repr(name), "a file in the scenario's own folder")
        if name.endswith(".json"):
            return load_map(folder / name)
        try:
            return load_map(name)
        except UnknownNameError:
            file, names = _file_called("map", name, folder), builtin_names()
            close = [file] if file else difflib.get_close_matches(name, names, n=1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            ways = f"a built-in map ({', '.join(names)}), one like it (NAME@SEED), or a .json file beside the scenario"
            expected = ways + hint
            document.fail(document.at("map"), repr(name), expected)

    return scenario_from(document, find_map)


def _write(path: Path, document: dict[str, Any]) -> None:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
