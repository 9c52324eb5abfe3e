"""JSON files of a league: small, written at once or not at all."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.files import replacing

MAX_BYTES = 1 << 22


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object.

    Raises:
        FileFormatError: it is missing, too large or broken.
    """
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise FileFormatError(path, "file size", found=f"{size} bytes", expected=f"at most {MAX_BYTES}")
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError(path, "file", found=str(error), expected="a league's file") from error
    if not isinstance(values, dict):
        raise FileFormatError(path, "file", found=type(values).__name__, expected="names and values")
    return values


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """Write a JSON object, at once or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
