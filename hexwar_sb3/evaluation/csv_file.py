"""Tables as text (`*.csv`): rows by the names of the head, numbers that are numbers."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from pathlib import Path

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.reading import read_bytes

MAX_BYTES = 1 << 22


def read_rows(path: Path) -> list[dict[str, str]]:
    """Read a table.

    Raises:
        FileFormatError: it is missing, too large, no text, or a row has more fields than the head.
    """
    data = read_bytes(path, MAX_BYTES, expected="a table (.csv)")
    try:
        reader = csv.DictReader(io.StringIO(data.decode("utf-8"), newline=""))
        rows = list(reader)
    except (csv.Error, ValueError) as error:
        raise FileFormatError(path, "file", found=str(error), expected="a table (.csv)") from error
    for number, row in enumerate(rows, start=2):
        if None in row or None in row.values():
            found, expected = "more or fewer fields", "as many as the head has"
            raise FileFormatError(path, f"row {number}", found=found, expected=expected)
    return rows


def number_in(row: Mapping[str, str], name: str, path: Path) -> float:
    """The number in a field of a row; NaN where the field is empty.

    Raises:
        FileFormatError: there is no such field, or it is no finite number.
    """
    text = row.get(name)
    try:
        value = float(text or "nan") if text is not None else math.inf
    except ValueError:
        value = math.inf
    if math.isinf(value) or (text and math.isnan(value)):
        raise FileFormatError(path, name, found=repr(text), expected="a finite number")
    return value
