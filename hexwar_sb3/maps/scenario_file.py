"""The content of a scenario file, both ways."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hexwar_sb3.errors import MapFileError
from hexwar_sb3.maps.document import Document, shown
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import map_document, map_from
from hexwar_sb3.maps.scenario import (
    MAX_CONTROL_POINTS,
    MAX_GAME_TICKS,
    MAX_POINT_VALUE,
    MAX_SIDE_PIECES,
    ControlPoint,
    PieceStart,
    Scenario,
    StartError,
)
from hexwar_sb3.rules.enums import Camp, PieceType

SCENARIO_FORMAT = "hexwar-scenario"
SCENARIO_VERSION = 1

_REQUIRED = ("format", "version", "name", "map", "game_ticks", "points", "pieces")
_OPTIONAL = ("net_score", "hash")
_CAMPS = {"red": Camp.RED, "blue": Camp.BLUE}
_KINDS = {kind.name.lower(): kind for kind in PieceType}


def scenario_document(scenario: Scenario, map_name: str | None = None) -> dict[str, Any]:
    """The content of a scenario file that names its map, or holds it if `map_name` is None."""
    name = scenario.hexmap.cell_name
    points = [{"name": p.name, "cell": name(p.cell), "value": p.value} for p in scenario.points]
    return {
        "format": SCENARIO_FORMAT,
        "version": SCENARIO_VERSION,
        "name": scenario.name,
        "hash": scenario.hash,
        "game_ticks": scenario.game_ticks,
        "net_score": scenario.net_score,
        "points": points,
        "pieces": [_piece_entry(piece, scenario.hexmap) for piece in scenario.pieces],
        "map": map_document(scenario.hexmap) if map_name is None else map_name,
    }


def scenario_from(document: Document, find_map: Callable[[str], HexMap]) -> Scenario:
    """The scenario that a document describes; `find_map` knows the map of a name."""
    document.only(_REQUIRED, _OPTIONAL)
    document.choice("format", (SCENARIO_FORMAT,))
    document.integer("version", SCENARIO_VERSION, SCENARIO_VERSION)
    hexmap = _read_map(document, find_map)
    counts = range(2, 2 * MAX_SIDE_PIECES + 1)
    pieces = [_read_piece(entry, hexmap) for entry in document.objects("pieces", counts)]
    points = document.objects("points", range(MAX_CONTROL_POINTS + 1))
    return _checked(
        document,
        name=document.text("name"),
        hexmap=hexmap,
        pieces=tuple(sorted(pieces, key=lambda piece: piece.camp)),
        points=tuple(_read_point(entry, hexmap) for entry in points),
        game_ticks=document.integer("game_ticks", 1, MAX_GAME_TICKS),
        net_score=document.flag("net_score"),
    )


def _piece_entry(piece: PieceStart, hexmap: HexMap) -> dict[str, Any]:
    entry: dict[str, Any] = {"camp": piece.camp.name.lower(), "name": piece.name}
    entry |= {"kind": piece.kind.name.lower(), "cell": hexmap.cell_name(piece.cell)}
    if piece.home is not None:
        entry |= {"home": piece.home, "aboard": piece.aboard}
    return entry


def _read_map(document: Document, find_map: Callable[[str], HexMap]) -> HexMap:
    if isinstance(document.data["map"], dict):
        place = document.at("map")
        return map_from(Document(document.data["map"], document.source, MapFileError, place))
    return find_map(document.text("map"))


def _read_piece(entry: Document, hexmap: HexMap) -> PieceStart:
    entry.only(("camp", "name", "kind", "cell"), ("home", "aboard"))
    return PieceStart(
        camp=_CAMPS[entry.choice("camp", _CAMPS)],
        name=entry.text("name"),
        kind=_KINDS[entry.choice("kind", _KINDS)],
        cell=entry.cell("cell", entry.text("cell"), hexmap.width, hexmap.height),
        home=entry.text("home") if "home" in entry.data else None,
        aboard=entry.flag("aboard"),
    )


def _read_point(entry: Document, hexmap: HexMap) -> ControlPoint:
    entry.only(("name", "cell", "value"))
    return ControlPoint(
        name=entry.text("name"),
        cell=entry.cell("cell", entry.text("cell"), hexmap.width, hexmap.height),
        value=entry.integer("value", 1, MAX_POINT_VALUE),
    )


def _checked(document: Document, **fields: Any) -> Scenario:
    camps = {piece.camp for piece in fields["pieces"]}
    if len(camps) < len(_CAMPS):
        document.fail(document.at("pieces"), "pieces of one camp only", "red and blue ones")
    try:
        scenario = Scenario(**fields)
    except StartError as error:
        place, found, expected = error.problem
        document.fail(document.at(place), found, expected)
    if document.data.get("hash", scenario.hash) != scenario.hash:
        expected = f'"{scenario.hash}", or no hash (take it out after an edit by hand)'
        document.fail(document.at("hash"), shown(document.data["hash"]), expected)
    return scenario
