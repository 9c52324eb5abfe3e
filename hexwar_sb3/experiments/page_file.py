"""`page.json` of a training: what was learned, as figures; read back by the experiments."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.kinds import fits, read_fields
from hexwar_sb3.reading import read_json

FILE = "page.json"


@dataclass(frozen=True, kw_only=True)
class PageRow:
    """What an experiment reads of a row: a player against an opponent in a camp."""

    player: str
    opponent: str
    win_rate: float
    mean_margin: float
    points_held: tuple[float, ...]


def minutes_on(folder: Path) -> float:
    """Minutes that a training took.

    Raises:
        FileFormatError: the page is broken.
    """
    found = read_json(folder / FILE, "a page").get("minutes")
    if not fits(found, float) or float(found) < 0.0:  # type: ignore[arg-type]  # it fits
        raise FileFormatError(folder / FILE, "minutes", found=repr(found), expected="a number of at least 0")
    return float(found)  # type: ignore[arg-type]


def rows_on(folder: Path) -> list[PageRow]:
    """Rows of a page.

    Raises:
        FileFormatError: the page is broken.
    """
    path = folder / FILE
    rows = read_json(path, "a page").get("rows")
    if not isinstance(rows, list):
        raise FileFormatError(path, "rows", found=repr(rows), expected="a list of rows")
    return [PageRow(**_read(path, n, row)) for n, row in enumerate(rows)]


def _read(path: Path, n: int, row: object) -> dict[str, Any]:
    names = PageRow.__dataclass_fields__
    own = {name: one for name, one in row.items() if name in names} if isinstance(row, dict) else row
    return read_fields(PageRow, own, path, place=f"rows[{n}]", whole=True)
