"""The file of a map's hot spots: G^L(k), the hull G^B and the boundaries (III-C, "Preprocessing").

One JSON object, a key a line: `schema`, `map` and `map_hash`, `source` (whose games were counted,
or "static rule"), `k`, for `red` and `blue` each `cells` (most visited first; the first k of them and
the control points are G^L(k)), `hull` (corner cells of G^B, in order) and `visits` (by cell), and
`walls`: pairs of neighbours between which no vehicle passes, because one lies too high above the other.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.document import Document, shown
from hexwar_sb3.maps.geometry import neighbour_cells
from hexwar_sb3.maps.hexmap import HexMap

SCHEMA = 2
SOURCE_CHARACTERS = 500
_HEAD = ("schema", "map", "map_hash", "source", "k")
_KEYS = (*_HEAD, "red", "blue", "walls")
_MAX_VISITS = 10**9
_MAX_WALLS = 190_000  # a map of 250 x 250 cells has fewer pairs of neighbours


@dataclass(frozen=True, kw_only=True)
class CampSpots:
    """One camp's side of the file; all cells are of the map, not of the camp's frame."""

    cells: tuple[int, ...]  # spots, the most visited first
    hull: tuple[int, ...]  # corners of G^B, counter-clockwise on a map with north above
    visits: Mapping[int, int]  # by cell, the most visited first


@dataclass(frozen=True, kw_only=True)
class HotSpots:
    """Hot spots of a map, as the file has them."""

    hexmap: HexMap
    source: str
    k: int  # spots that the hull encloses
    camps: tuple[CampSpots, CampSpots]  # [red, blue]
    walls: tuple[tuple[int, int], ...]  # pairs of neighbours, the first one west or north of the second

    def document(self) -> dict[str, Any]:
        """The JSON object of the file."""
        hexmap = self.hexmap
        head = dict(zip(_HEAD, (SCHEMA, hexmap.name, hexmap.hash, self.source, self.k), strict=True))
        camps = {camp_name(camp): _camp_document(self.camps[camp], hexmap) for camp in SIDES}
        return head | camps | {"walls": ["-".join(_names(pair, hexmap)) for pair in self.walls]}

    def save(self, path: str | Path) -> None:
        """Write the file, whole or not at all."""
        lines = [f" {json.dumps(key)}: {json.dumps(value)}" for key, value in self.document().items()]
        with replacing(Path(path)) as temporary:
            temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def read_spots(path: str | Path, hexmap: HexMap) -> HotSpots:
    """Read the hot spots of a map.

    Raises:
        FileFormatError: the file cannot be used, or is of another map; it says where and why.
    """
    return spots_from(Document.read(Path(path), FileFormatError), hexmap)


def spots_from(document: Document, hexmap: HexMap) -> HotSpots:
    """The hot spots of a map that a document describes; its error if it describes none."""
    document.has("schema")
    document.integer("schema", SCHEMA, SCHEMA)
    document.only(_KEYS)
    if document.text("map_hash") != hexmap.hash:
        document.fail("map_hash", shown(document.data["map_hash"]), f'"{hexmap.hash}", the map {hexmap.name}')
    red, blue = (_read_camp(document, camp_name(camp), hexmap) for camp in SIDES)
    most = min(len(red.cells), len(blue.cells))
    return HotSpots(
        hexmap=hexmap,
        source=document.text("source", SOURCE_CHARACTERS),
        k=document.integer("k", 0, most),
        camps=(red, blue),
        walls=_read_walls(document, hexmap),
    )


def _camp_document(spots: CampSpots, hexmap: HexMap) -> dict[str, Any]:
    visits = dict(zip(_names(spots.visits, hexmap), spots.visits.values(), strict=True))
    return {"cells": _names(spots.cells, hexmap), "hull": _names(spots.hull, hexmap), "visits": visits}


def _names(cells: Iterable[int], hexmap: HexMap) -> list[str]:
    return [hexmap.cell_name(cell) for cell in cells]


def _read_camp(document: Document, camp: str, hexmap: HexMap) -> CampSpots:
    part = Document(document.data[camp], document.source, document.error, camp)
    part.only(("cells", "hull", "visits"))
    cells, hull = (_read_cells(part, key, hexmap) for key in ("cells", "hull"))
    visits = Document(part.data["visits"], part.source, part.error, part.at("visits"))
    if len(visits.data) > hexmap.n_cells:
        visits.fail(visits.place, f"{len(visits.data)} entries", "a cell of the map each")
    counted = {
        int(visits.cell(name, name, hexmap.width, hexmap.height)): visits.integer(name, 1, _MAX_VISITS)
        for name in visits.data
    }
    return CampSpots(cells=cells, hull=hull, visits=counted)


def _read_cells(part: Document, key: str, hexmap: HexMap) -> tuple[int, ...]:
    names = part.texts(key, range(hexmap.n_cells))
    if len(set(names)) < len(names):
        twice = next(name for name, times in Counter(names).items() if times > 1)
        part.fail(part.at(key), f"{shown(twice)} twice", "each cell once")
    return tuple(part.cell(key, name, hexmap.width, hexmap.height) for name in names)


def _read_walls(document: Document, hexmap: HexMap) -> tuple[tuple[int, int], ...]:
    walls, neighbours = [], neighbour_cells(hexmap.width, hexmap.height)
    for text in document.texts("walls", range(_MAX_WALLS)):
        a, _, b = text.partition("-")
        first, second = (document.cell("walls", name, hexmap.width, hexmap.height) for name in (a, b))
        if second not in neighbours[first]:
            document.fail("walls", shown(text), "two neighbours")
        walls.append((int(first), int(second)))
    return tuple(walls)
