"""Folders that one process at a time works in, its own workers apart, and folders that are made whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path

from hexwar_sb3.errors import HexWarError
from hexwar_sb3.files import UNFINISHED, _check_held, _held, _identity, only_one

Held = Mapping[Path, tuple[int, int]]


@contextmanager
def holding(folder: Path, what: str) -> Iterator[None]:
    """Hold a folder while the block runs, as `only_one` does; who holds one above it, holds it.

    Args:
        folder: made if it is missing.
        what: lies there, in a word, for the message.

    Raises:
        BusyError: another process holds it.
        FileNotFoundError: it was removed while it was held.
    """
    place = folder.resolve()
    is_held = any(above in _held for above in (place, *place.parents))
    if is_held:
        check_held(folder)
    with nullcontext() if is_held else only_one(folder, what):
        try:
            yield
        except (OSError, HexWarError):
            check_held(folder)  # a removed folder leads to errors of many kinds: this one says it
            raise


def check_held(path: Path) -> None:
    """Check before something is made that the held folder where it is to lie is still there.

    Raises:
        FileNotFoundError: it was removed.
    """
    _check_held(path / UNFINISHED)


def held() -> dict[Path, tuple[int, int]]:
    """Folders that this process holds, for the workers that it hands jobs to."""
    return dict(_held)


def work_within(folders: Held) -> None:
    """Count folders as held that the parent of this process holds: they are not made anew, either."""
    _held.clear()
    _held.update(folders)


def work_for_holder(folder: Path) -> None:
    """Count one as held that the parent of this process holds.

    Raises:
        FileNotFoundError: it is gone.
    """
    place = folder.resolve()
    work_within({place: _identity(place)})


@contextmanager
def making(folder: Path) -> Iterator[Path]:
    """Give a temporary folder that becomes `folder` when the block ends well: at once or not at all.

    Raises:
        OSError: it cannot be made, or lies in one that was held and removed.
    """
    check_held(folder.parent)
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(prefix=UNFINISHED, dir=folder.parent)) / folder.name
    made.mkdir()  # with the user's own mode; mkdtemp's shuts others out
    try:
        yield made
        check_held(folder.parent)
        _publish(made, folder)
    finally:
        shutil.rmtree(made.parent, ignore_errors=True)


def _publish(made: Path, folder: Path) -> None:
    """Give a finished folder its place; one that another process has put there stays."""
    try:
        made.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise
