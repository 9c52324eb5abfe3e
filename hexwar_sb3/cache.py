"""The cache folder: where it lies, who may write there, and what is too old to stay.

All that lies in it can be made again: compiled kernels and the tables of maps. Kernels are code, so whoever can write
there decides what this program runs: a folder that strangers can write to is not used. Every file carries its own
name, what it holds and a checksum; one that does not fit is as good as none.
"""

from __future__ import annotations

import errno
import logging
import mmap
import os
import re
import stat
import tempfile
import time
import zlib
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from multiprocessing import parent_process
from pathlib import Path
from typing import BinaryIO

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.files import replacing
from hexwar_sb3.reading import opened

KEPT_DAYS = 30  # after its last use
HEAD_BYTES = 4096  # of every file, so that what follows can be mapped
_MOST_BYTES = 1 << 28  # of one file that is read as a whole
_ADVICE = "set HEXWAR_CACHE to a folder of your own"
_DAY = 24 * 60 * 60.0  # seconds
_OLD = (  # what this version and earlier ones file
    *(r"kernels-[0-9a-f]{16}/[^/]+\.(kernel|list)", r"kernels-[0-9a-f]{16}/[^/]+/[^/]+\.nb[ci][^/]*"),
    *(r"terrain/[0-9a-f]{16}-[a-z]+\.(table|npy)", r"(kernels-[0-9a-f]{16}|terrain)/\.new-[^/]+"),
    r"prepared-[0-9a-f]{16}",
)
_FOLDERS = ("kernels-*", "terrain", "kernels-*/*")
_PRUNED = "pruned"  # file that says when that was done last
_log = logging.getLogger("hexwar_sb3")
try:
    _start = str(Path.cwd())  # where a relative HEXWAR_CACHE begins
except OSError:  # a folder that was removed
    _start = ""


@dataclass(frozen=True)
class Cache:
    """One cache folder, and a private temporary one for what cannot be kept in it.

    Args:
        named: the folder by the settings; None: there is no home for it.
    """

    named: Path | None
    lost: set[str] = field(default_factory=set, compare=False)  # names of what could not be kept

    @cached_property
    def trouble(self) -> str:
        """Why nothing new can be kept in the folder that is named; empty: it can."""
        if self.named is None:
            return "there is no home folder"
        try:
            self.named.mkdir(mode=0o700, parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=self.named).close()
            return _distrust(self.named)
        except (OSError, ValueError) as error:  # ValueError: a path that no system knows
            is_file = isinstance(error, FileExistsError | NotADirectoryError)
            return "it is not a folder" if is_file else _short(error)

    @cached_property
    def place(self) -> Path | None:
        """Folder for what is new; None if there is none. The user is told once if it is not the named one."""
        if not self.trouble:
            return self.named
        instead = _temporary()
        if parent_process() is None:
            where = f"in {instead} instead" if instead else "nowhere, so every start compiles for minutes"
            named = f" {self.named}" if self.named else ""
            says = "cannot use the cache folder%s: %s; kernels are kept %s; %s"
            _log.warning(says, named, self.trouble, where, _ADVICE)
        return instead

    def folders(self, part: str) -> Iterator[Path]:
        """Folders of one part, such as "terrain", that may be read."""
        for place in (self.named, _temporary() if self.trouble else None):
            if place is not None:
                with suppress(OSError):
                    if not _distrust(place) and not _distrust(place / part):
                        yield place / part

    def read(self, part: str, name: str) -> bytes | None:
        """What is kept under a name; None if nothing is, or it is damaged."""
        for folder in self.folders(part):
            with suppress(FileFormatError, OSError), _entry(folder / name) as (head, file):
                data = file.read(_MOST_BYTES)
                if head == _head(name, "", data):
                    return data
        return None

    def map(self, part: str, name: str, what: str, size: int) -> memoryview | None:
        """What is kept under a name, mapped into memory and read-only; None if there is none of this kind and size."""
        for folder in self.folders(part):
            with suppress(FileFormatError, OSError), _entry(folder / name) as (head, file):
                if os.fstat(file.fileno()).st_size != HEAD_BYTES + size:
                    continue
                data = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))[HEAD_BYTES:]
                if head == _head(name, what, data):
                    return data
        return None

    def keep(self, part: str, name: str, data: bytes | memoryview, what: str = "") -> bool:
        """File something under a name, at once or not at all; whether it is kept."""
        if self.place is None:
            return False
        try:
            folder = self.place / part
            self.place.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(mode=0o755, exist_ok=True)
            if _distrust(folder):
                raise PermissionError(errno.EPERM, _distrust(folder))
            with replacing(folder / name) as temporary, temporary.open("wb") as file:
                file.write(_head(name, what, data))
                file.write(data)
        except OSError as error:  # a full disk, or the folder went away
            if not self.lost:
                says = "cannot write to the cache folder %s: %s; what is missing is made again at every start; %s"
                _log.warning(says, self.place, _short(error), _ADVICE)
            self.lost.add(name)
            return False
        return True

    def names(self, part: str) -> list[str]:
        """Names of all that is kept in one part."""
        return sorted({path.name for path in self._files(part)})

    def use(self, part: str, names: Collection[str]) -> bool:
        """Whether all these are there; then they count as used now."""
        left = set(names)
        for path in self._files(part):
            if path.name in left:
                _touch(path)
                left.discard(path.name)
        return not left

    def _files(self, part: str) -> list[Path]:
        found: list[Path] = []
        for folder in self.folders(part):
            with suppress(OSError):
                found += folder.iterdir()
        return found

    def prune(self) -> None:
        """Remove what nobody used for KEPT_DAYS, once a day at most; nothing but files that this program makes."""
        place = _temporary() if self.trouble else self.named
        now = time.time()
        if place is None or now - used_at(place / _PRUNED) < _DAY:
            return
        with suppress(OSError):
            (place / _PRUNED).touch()
        emptied: set[Path] = set()
        for path in files_of(place):
            if used_at(path) < now - KEPT_DAYS * _DAY:
                with suppress(OSError):
                    path.unlink()
                    emptied |= set(path.relative_to(place).parents) - {Path()}
        for folder in sorted(emptied, reverse=True):
            with suppress(OSError):
                (place / folder).rmdir()  # if nothing else lies there


def cache_root() -> Path | None:
    """Folder for everything that can be made again, usable or not; None without a home.

    `HEXWAR_CACHE` names it; otherwise it lies in the user's cache folder.
    """
    named = os.environ.get("HEXWAR_CACHE")
    if named:
        path = Path(os.path.expanduser(named))  # noqa: PTH111  Path.expanduser raises where there is no home
        is_unknown = path.parts[:1] and path.parts[0].startswith("~")
        return None if is_unknown or not (_start or path.is_absolute()) else Path(_start or "", path)
    caches = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if caches.is_absolute():  # the standard ignores any other
        return caches / "hexwar_sb3"
    home = Path(os.path.expanduser("~"))  # noqa: PTH111
    return home / ".cache" / "hexwar_sb3" if home.is_absolute() and os.environ.get("HOME") != "" else None


def cache() -> Cache:
    """The cache by the settings of this moment."""
    return _cache(cache_root())


_cache = lru_cache(Cache)


def _distrust(folder: Path) -> str:
    """Why what lies in a folder may be a stranger's; empty: it is ours or the system's."""
    if os.name != "posix":
        return ""
    found = folder.stat()
    if found.st_uid not in (0, os.geteuid()):
        return "it belongs to another user, who could change the code in it"
    return "everybody may write there, and change the code in it" if found.st_mode & stat.S_IWOTH else ""


@lru_cache
def _temporary() -> Path | None:
    """A folder of this user alone among the temporary ones, the same for all processes."""
    try:
        user = str(os.geteuid()) if os.name == "posix" else ""
        folder = Path(tempfile.gettempdir(), f"hexwar_sb3-{user}")
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        is_private = found.st_uid == os.geteuid() and not found.st_mode & 0o077 if user else True
        if not stat.S_ISDIR(found.st_mode) or not is_private:
            return None
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return None
    return folder


@contextmanager
def _entry(path: Path) -> Iterator[tuple[bytes, BinaryIO]]:
    """A kept file behind its head; it counts as used."""
    with opened(path) as file:
        _touch(path)
        yield file.read(HEAD_BYTES), file


def _head(name: str, what: str, data: bytes | memoryview) -> bytes:
    """How a file begins: its name, what it holds, and a checksum against damage."""
    text = f"hexwar_sb3 {name} {memoryview(data).nbytes} {zlib.crc32(data):08x} {what}\n"
    return text.encode().ljust(HEAD_BYTES, b"\0")


def used_at(path: Path) -> float:
    """When a file was made or used last, in seconds; 0 if there is none."""
    try:
        found = path.lstat()
    except OSError:
        return 0.0
    return max(found.st_atime, found.st_mtime)


def _touch(path: Path) -> None:
    """Note the use of a file, once a day at most; not every system does so by itself."""
    with suppress(OSError):
        if time.time() - path.stat().st_mtime > _DAY:
            os.utime(path)


def files_of(place: Path) -> Iterator[Path]:
    """Files of this program in a cache folder: by name alone, as the folder may hold anything."""
    for folder in (place, *(folder for pattern in _FOLDERS for folder in place.glob(pattern))):
        if folder.is_dir() and not folder.is_symlink():
            for path in folder.iterdir():
                is_ours = any(re.fullmatch(old, path.relative_to(place).as_posix()) for old in _OLD)
                if is_ours and stat.S_ISREG(path.lstat().st_mode):
                    yield path


def _short(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
