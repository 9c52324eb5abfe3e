"""Folders that one process at a time works in, its own workers apart, and folders that are made whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path

from filelock import FileLock, Timeout

from hexwar_sb3.errors import BusyError, HexWarError
from hexwar_sb3.files import UNFINISHED, check_held, held_folders, identity_of, remove_if_left

LOCK = ".lock"  # file of a folder that one process at a time may work in
Held = Mapping[Path, tuple[int, int]]


@contextmanager
def holding(folder: Path, what: str) -> Iterator[None]:
    """Hold a folder while the block runs: no other process may work in it. Who holds one above it, holds it.

    What killed processes were writing there is removed first. While the folder is held, nothing makes it anew: whoever
    removes it ends the run.

    Args:
        folder: made if it is missing.
        what: lies there, in a word, for the message.

    Raises:
        BusyError: another process holds it.
        FileNotFoundError: it was removed while it was held.
    """
    place = folder.resolve()
    is_held = any(above in held_folders for above in (place, *place.parents))
    if is_held:
        check_held(folder)
    with nullcontext() if is_held else _only_one(folder, what):
        try:
            yield
        except (OSError, HexWarError):
            check_held(folder)  # a removed folder leads to errors of many kinds: this one says it
            raise


@contextmanager
def _only_one(folder: Path, what: str) -> Iterator[None]:
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise BusyError(f"{folder}: another process is working on this {what}") from error
    place = folder.resolve()
    try:
        _clear_leftovers(folder)
        held_folders[place] = identity_of(place)
        yield
    finally:
        held_folders.pop(place, None)
        lock.release()


def _clear_leftovers(folder: Path) -> None:
    """Remove what killed processes were writing in a folder and below; files of living ones stay."""
    for left in folder.rglob(f"{UNFINISHED}*"):
        if left.is_dir() and not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
        else:
            remove_if_left(left)


def held() -> dict[Path, tuple[int, int]]:
    """Folders that this process holds, for the workers that it hands jobs to."""
    return dict(held_folders)


def work_within(folders: Held) -> None:
    """Count folders as held that the parent of this process holds: they are not made anew, either."""
    held_folders.clear()
    held_folders.update(folders)


def work_for_holder(folder: Path) -> None:
    """Count one as held that the parent of this process holds.

    Raises:
        FileNotFoundError: it is gone.
    """
    place = folder.resolve()
    work_within({place: identity_of(place)})


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
