"""Writing files so that a full disk or a kill leaves the old file whole; a folder for one process at a time."""

from __future__ import annotations

import errno
import glob
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from hexwar_sb3.errors import BusyError

UNFINISHED = ".new-"  # begins the names of files and folders that are being written
LOCK = ".lock"  # file of a folder that one process at a time may work in
_held: dict[Path, tuple[int, int]] = {}  # folders that this process holds: device and number

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
        >>> with replacing(Path("config.json")) as temporary:
        ...     temporary.write_text("{}")
    """
    _check_held(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    start = f"{UNFINISHED}{path.stem}-"
    for left in path.parent.glob(f"{glob.escape(start)}*{glob.escape(path.suffix)}"):
        _remove_if_left(left)
    handle, name = tempfile.mkstemp(prefix=start, suffix=path.suffix, dir=path.parent)
    temporary = Path(name)
    try:
        _mark(handle)
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp's own mode shuts other users out
        _check_held(path)
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


def _remove_if_left(path: Path) -> None:
    """Remove a temporary file whose process is gone."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDWR | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))
        try:
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        finally:
            os.close(handle)
        path.unlink()


def clear_leftovers(folder: Path) -> None:
    """Remove what killed processes were writing in a folder and below; files of living ones stay."""
    for left in folder.rglob(f"{UNFINISHED}*"):
        if left.is_dir() and not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
        else:
            _remove_if_left(left)


@contextmanager
def only_one(folder: Path, what: str) -> Iterator[None]:
    """Hold a folder while the block runs: no other process may work in it.

    What killed processes were writing there is removed first. While the folder is held, `replacing` does not make
    it anew: whoever removes it ends the run.

    Args:
        folder: made if it is missing.
        what: lies there, in a word, for the message.

    Raises:
        BusyError: another process holds it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise BusyError(f"{folder}: another process is working on this {what}") from error
    place = folder.resolve()
    try:
        clear_leftovers(folder)
        _held[place] = _identity(place)
        yield
    finally:
        _held.pop(place, None)
        lock.release()


def _identity(folder: Path) -> tuple[int, int]:
    found = folder.stat()
    return found.st_dev, found.st_ino


def _check_held(path: Path) -> None:
    """Check that the folder that this process holds, if the file lies in one, is still the same."""
    if not _held:
        return
    resolved = path.absolute().parent.resolve()
    for folder, identity in _held.items():
        if resolved == folder or folder in resolved.parents:
            try:
                is_same = _identity(folder) == identity
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
