"""Writing files so that a full disk or a kill leaves the old file whole; small JSON files."""

from __future__ import annotations

import errno
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError

MAX_JSON_BYTES = 1 << 22


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary file that takes the place of `path` when the block ends well.

    It keeps the suffix of `path` and lies in its folder, so that the last step is one rename. After
    an error `path` is as it was.

    Example:
        >>> with replacing(Path("config.json")) as temporary:
        ...     temporary.write_text("{}")
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=".new-", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp's own mode shuts other users out
        temporary.replace(path)
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise OSError(error.errno, "no space left; the file is as it was before", str(path)) from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def read_json(path: Path, expected: str = "names and values") -> dict[str, Any]:
    """Read a JSON object.

    Args:
        path: of the file.
        expected: what it should be, in words.

    Raises:
        FileFormatError: it is missing, too large or broken.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_JSON_BYTES + 1)
    except OSError as error:
        found = error.strerror or type(error).__name__
        raise FileFormatError(path, "file", found=found, expected=expected) from error
    if len(data) > MAX_JSON_BYTES:
        found, most = f"more than {MAX_JSON_BYTES} bytes", f"at most {MAX_JSON_BYTES}"
        raise FileFormatError(path, "file size", found=found, expected=most)
    try:
        values = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(path, "text", found=str(error), expected=f"{expected} as JSON") from error
    if not isinstance(values, dict):
        raise FileFormatError(path, "file", found=type(values).__name__, expected=expected)
    return values


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """Write a JSON object, at once or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
