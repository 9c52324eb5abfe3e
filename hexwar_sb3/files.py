"""Writing files so that a full disk or a kill leaves the old file whole."""

from __future__ import annotations

import errno
import glob
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

UNFINISHED = ".new-"  # begins the names of files and folders that are being written
held_folders: dict[Path, tuple[int, int]] = {}  # that this process holds, or its parent: device and number

try:
    import fcntl
except ImportError:  # Windows: a file that is open cannot be removed there, which serves as well
    fcntl = None  # type: ignore[assignment]


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary file that takes the place of `path` when the block ends well.

    It keeps the suffix of `path` and lies in its folder, so that the last step is one rename. After
    an error `path` is as it was. What a killed process left of an earlier attempt goes away.

    Raises:
        OSError: it cannot be written, or lies in a folder that this process holds and that was removed meanwhile.

    Example:
        >>> from pathlib import Path
        >>> with replacing(Path("config.json")) as temporary:
        ...     temporary.write_text("{}")
        2
    """
    check_held(path.parent)
    path.parent.mkdir(parents=True, exist_ok=True)
    start = f"{UNFINISHED}{path.stem}-"
    for left in path.parent.glob(f"{glob.escape(start)}*{glob.escape(path.suffix)}"):
        remove_if_left(left)
    handle, name = tempfile.mkstemp(prefix=start, suffix=path.suffix, dir=path.parent)
    temporary = Path(name)
    try:
        _mark(handle)
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp's own mode shuts other users out
        check_held(path.parent)
        temporary.replace(path)
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise OSError(error.errno, "no space left; the file is as it was before", str(path)) from error
        raise
    finally:
        os.close(handle)
        temporary.unlink(missing_ok=True)


def _mark(handle: int) -> None:
    """Show that somebody writes: the lock ends with the process, however it ends."""
    if fcntl is not None:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def held(handle: int) -> bool:
    """Hold an open file until it is closed; whether nobody else does."""
    with suppress(OSError):  # a file system without locks
        try:
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


def remove_if_left(path: Path) -> None:
    """Remove a temporary file whose process is gone."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDWR | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))
        try:
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        finally:
            os.close(handle)
        path.unlink()


def identity_of(folder: Path) -> tuple[int, int]:
    """Device and number of a folder."""
    found = folder.stat()
    return found.st_dev, found.st_ino


def check_held(place: Path) -> None:
    """Check before something is made in a folder that the held one there or above, if there is one, is still the same.

    Raises:
        FileNotFoundError: it was removed.
    """
    if not held_folders:
        return
    resolved = place.resolve()
    for folder, identity in held_folders.items():
        if resolved == folder or folder in resolved.parents:
            try:
                is_same = identity_of(folder) == identity
            except FileNotFoundError:
                is_same = False
            if not is_same:
                raise FileNotFoundError(
                    errno.ENOENT, "the folder was removed while it was in use", str(folder)
                )


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """Write a JSON object, at once or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


def write_entries(path: Path, entries: Mapping[str, Any]) -> None:
    """Write a JSON object with a line an entry, sorted by name, at once or not at all."""
    lines = [f"{json.dumps(name)}: {json.dumps(entries[name])}" for name in sorted(entries)]
    with replacing(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
