"""The content of a map file, both ways.

A row of text runs from west to east; rows of odd y (every second one) are one cell shorter.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hexwar_sb3.maps.document import Document, shown
from hexwar_sb3.maps.geometry import MAX_SIDE_CELLS, MIN_SIDE_CELLS, Bools, row_cells
from hexwar_sb3.maps.hexmap import HexMap

MAP_FORMAT = "hexwar-map"
MAP_VERSION = 1
MAX_GRADE_M = 100
MAX_ALTITUDE_M = 9000
MAX_CONTROLLABLE = 64

PASSABLE, PAVED, CONCEALED, SLUSHY = 1, 2, 4, 8
SYMBOLS = {
    ".": PASSABLE,  # open
    "f": PASSABLE | CONCEALED,  # forest
    "m": PASSABLE | SLUSHY,  # marsh
    "w": PASSABLE | CONCEALED | SLUSHY,  # wet forest
    "=": PASSABLE | PAVED,  # road
    "b": PASSABLE | PAVED | CONCEALED,  # built-up street
    "d": PASSABLE | PAVED | SLUSHY,  # causeway: a road through marsh
    "e": PASSABLE | PAVED | CONCEALED | SLUSHY,  # causeway through wet forest
    "~": 0,  # lake
    "x": PAVED,  # roadblock
    "^": CONCEALED,  # thicket
}
_SYMBOL_OF = {bits: symbol for symbol, bits in SYMBOLS.items()}
_REQUIRED = (
    *("format", "version", "name", "width", "height", "grade_m"),
    *("controllable", "terrain", "levels"),
)
_OPTIONAL = ("seed", "hash")

Levels = npt.NDArray[np.int64]


def map_document(hexmap: HexMap) -> dict[str, Any]:
    """The content of a map file."""
    return {
        "format": MAP_FORMAT,
        "version": MAP_VERSION,
        "name": hexmap.name,
        "seed": hexmap.seed,
        "hash": hexmap.hash,
        "width": hexmap.width,
        "height": hexmap.height,
        "grade_m": hexmap.grade_m,
        "controllable": [hexmap.cell_name(int(c)) for c in np.flatnonzero(hexmap.controllable)],
        "terrain": _terrain_rows(hexmap),
        "levels": _level_rows(hexmap),
    }


def map_from(document: Document) -> HexMap:
    """The map that a document describes; its error if it describes none."""
    document.only(_REQUIRED, _OPTIONAL)
    document.choice("format", (MAP_FORMAT,))
    document.integer("version", MAP_VERSION, MAP_VERSION)
    width = document.integer("width", MIN_SIDE_CELLS, MAX_SIDE_CELLS)
    height = document.integer("height", MIN_SIDE_CELLS, MAX_SIDE_CELLS)
    grade_m = document.integer("grade_m", 1, MAX_GRADE_M)
    bits = _read_terrain(document, width, height)
    levels = _read_levels(document, width, height, MAX_ALTITUDE_M // grade_m)
    hexmap = HexMap(
        name=document.text("name"),
        grade_m=grade_m,
        elev_m=(levels * grade_m).astype(np.int16),
        passable=bits & PASSABLE > 0,
        paved=bits & PAVED > 0,
        concealed=bits & CONCEALED > 0,
        slushy=bits & SLUSHY > 0,
        controllable=_read_controllable(document, width, height),
        seed=_read_seed(document),
    )
    _check_hash(document, hexmap)
    return hexmap


def _terrain_rows(hexmap: HexMap) -> list[str]:
    bits = hexmap.passable * PASSABLE + hexmap.paved * PAVED
    bits += hexmap.concealed * CONCEALED + hexmap.slushy * SLUSHY
    rows = [row[: row_cells(y, hexmap.width)] for y, row in enumerate(bits.tolist())]
    return ["".join(_SYMBOL_OF[value] for value in row) for row in rows]


def _level_rows(hexmap: HexMap) -> list[str]:
    levels = (hexmap.elev_m // hexmap.grade_m).tolist()
    rows = [row[: row_cells(y, hexmap.width)] for y, row in enumerate(levels)]
    return [" ".join(map(str, row)) for row in rows]


def _read_terrain(document: Document, width: int, height: int) -> Levels:
    bits = np.zeros((height, width), np.int64)
    for y, row in enumerate(document.texts("terrain", range(height, height + 1))):
        _check_cells(document, "terrain", y, len(row), width)
        for x, symbol in enumerate(row):
            if symbol not in SYMBOLS:
                place = f"terrain[{y}], character {x + 1}"
                document.fail(document.at(place), shown(symbol), f"one of {' '.join(SYMBOLS)}")
            bits[y, x] = SYMBOLS[symbol]
    return bits


def _read_levels(document: Document, width: int, height: int, highest: int) -> Levels:
    levels = np.zeros((height, width), np.int64)
    for y, row in enumerate(document.texts("levels", range(height, height + 1))):
        words = row.split()
        _check_cells(document, "levels", y, len(words), width)
        for x, word in enumerate(words):
            if not (word.isascii() and word.isdecimal() and len(word) <= 4 and int(word) <= highest):
                place = f"levels[{y}], number {x + 1}"
                document.fail(document.at(place), shown(word), f"a level from 0 to {highest}")
            levels[y, x] = int(word)
    return levels


def _check_cells(document: Document, key: str, y: int, found: int, width: int) -> None:
    expected = row_cells(y, width)
    if found != expected:
        note = f"{expected} (width {width}, one less in every second row)"
        document.fail(document.at(f"{key}[{y}]"), f"{found} cells", note)


def _read_controllable(document: Document, width: int, height: int) -> Bools:
    marks = np.zeros((height, width), np.bool_)
    for i, name in enumerate(document.texts("controllable", range(MAX_CONTROLLABLE + 1))):
        marks.flat[document.cell(f"controllable[{i}]", name, width, height)] = True
    return marks


def _read_seed(document: Document) -> int | None:
    if document.data.get("seed") is None:
        return None
    return document.integer("seed", 0, 2**63 - 1)


def _check_hash(document: Document, hexmap: HexMap) -> None:
    found = document.data.get("hash", hexmap.hash)
    if found != hexmap.hash:
        expected = f'"{hexmap.hash}", or no hash (take it out after an edit by hand)'
        document.fail(document.at("hash"), shown(found), expected)
