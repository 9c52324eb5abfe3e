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
    camp: str
    win_rate: float
    mean_margin: float
    points_held: tuple[float, ...]  # shares of the games with 0, 1, 2, ... of them

    @property
    def mean_points(self) -> float:
        """Control points held, on average."""
        return sum(k * share for k, share in enumerate(self.points_held))


def minutes_on(folder: Path) -> float:
    """Minutes that a training took.

    Raises:
        FileFormatError: the page is broken.
    """
    found = read_json(folder / FILE, "a page").get("minutes")
    if not fits(found, float) or float(found) < 0.0:  # type: ignore[arg-type]  # it fits
        raise FileFormatError(folder / FILE, "minutes", found=repr(found), expected="a number of at least 0")
    return float(found)  # type: ignore[arg-type]


def rows_on(folder: Path, *parts: str) -> list[PageRow]:
    """Rows of a page.

    Args:
        folder: of the run.
        parts: of the page; "rows" if none is named, where "others" holds those of the trained player against others.

    Raises:
        FileFormatError: the page is broken.
    """
    path = folder / FILE
    page, found = read_json(path, "a page"), list[PageRow]()
    for part in parts or ("rows",):
        rows = page.get(part)
        if not isinstance(rows, list):
            raise FileFormatError(path, part, found=repr(rows), expected="a list of rows")
        found += [PageRow(**_read(path, f"{part}[{n}]", row)) for n, row in enumerate(rows)]
    return found


def _read(path: Path, place: str, row: object) -> dict[str, Any]:
    names = PageRow.__dataclass_fields__
    own = {name: one for name, one in row.items() if name in names} if isinstance(row, dict) else row
    return read_fields(PageRow, own, path, place=place, whole=True)
