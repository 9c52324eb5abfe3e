"""What lies in the cache folder: how much, for which versions, what of it this version does not use."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from hexwar_sb3 import kernels
from hexwar_sb3.cache import KEPT_DAYS, Cache, files_of, used_at

IN_USE, OTHER_SOURCES, OTHER_PYTHON, EARLIER, MAPS = (
    "in use",
    "other sources",
    "other Python",
    "earlier",
    "maps",
)
STALE = (OTHER_SOURCES, OTHER_PYTHON, EARLIER)
_SUFFIXES = (".kernel", ".list")  # of what this version keeps of kernels
_WORDS = {
    IN_USE: "kernels in use",
    OTHER_SOURCES: "of other sources",
    OTHER_PYTHON: "of other Pythons",
    EARLIER: "of before 0.2",
    MAPS: "tables of maps",
}
_DAY = 86_400.0  # seconds


@dataclass
class Lot:
    """Files of one kind."""

    paths: list[Path] = field(default_factory=list)
    size: int = 0  # bytes
    used_at: float = 0.0  # seconds since the epoch, of the file that was used last

    def add(self, path: Path) -> None:
        """Count a file; one that somebody removes meanwhile is none."""
        with suppress(OSError):
            self.size += path.lstat().st_size
            self.paths.append(path)
            self.used_at = max(self.used_at, used_at(path))

    def __str__(self) -> str:
        """Say how much it is, and when it was used last."""
        days = int(max(0.0, time.time() - self.used_at) / _DAY)
        when = "today" if days == 0 else f"{days} day{'s' * (days != 1)} ago"
        return f"{self.size / 1e6:.0f} MB, {len(self.paths)} files, used last {when}"


def lots(place: Path) -> dict[str, Lot]:
    """Sort the files of this program in a cache folder by who can use them."""
    found = {kind: Lot() for kind in _WORDS}
    hashes = current_sources()
    for path in files_of(place):
        found[_kind(path.relative_to(place), hashes)].add(path)
    return found


def _kind(path: Path, hashes: frozenset[str]) -> str:
    """Who can use a file."""
    part, is_new = path.parts[0], path.suffix in _SUFFIXES and len(path.parts) == 2
    if path.parts[0] == "terrain" and path.suffix != ".npy":
        return MAPS
    if not is_new:
        return EARLIER
    if part != kernels.toolchain():
        return OTHER_PYTHON
    return IN_USE if hashes & set(path.stem.split("-")) else OTHER_SOURCES


def current_sources() -> frozenset[str]:
    """Hashes under which this version files its kernels."""
    package = Path(kernels.__file__).parent
    files = (
        path
        for path in package.rglob("*.py")
        if path.name == "prepare.py" or "@kernel" in path.read_text("utf-8")
    )
    return frozenset(kernels.source_hash(path) for path in files)


def describe(cache: Cache, place: Path) -> Iterator[tuple[str, str]]:
    """Say what lies there, line by line."""
    found = lots(place)
    notes = {
        IN_USE: made_for(cache, kernels.toolchain()),
        OTHER_SOURCES: "of another version, or of another copy of hexwar_sb3",
        OTHER_PYTHON: "; ".join(_others(cache, place)),
        EARLIER: "nothing reads them any more",
        MAPS: "of all that were played",
    }
    for kind, lot in found.items():
        if lot.paths:
            yield _WORDS[kind], f"{lot}: {notes[kind]}"
    stale = sum(found[kind].size for kind in STALE)
    if stale:
        yield "to delete them", f"hexwar doctor --clean frees {stale / 1e6:.0f} MB"
    yield (
        "to delete all",
        f"remove {place}: the next start takes two minutes; what is unused goes after {KEPT_DAYS} days",
    )


def _others(cache: Cache, place: Path) -> Iterator[str]:
    """For what the kernels of each other folder are."""
    for folder in sorted(place.glob("kernels-*")):
        if folder.name != kernels.toolchain() and any(folder.glob("*.kernel")):
            yield made_for(cache, folder.name)


def made_for(cache: Cache, part: str) -> str:
    """Versions for which the kernels of a folder were made ahead."""
    lists = [name for name in cache.names(part) if name.startswith("prepared-") and name.endswith(".list")]
    said = {(cache.read(part, name) or b"").decode("utf-8", "replace").partition("\n")[0] for name in lists}
    return (
        ", and ".join(sorted(line for line in said if line.startswith("hexwar")))
        or "of versions that are not known"
    )


def clean(place: Path) -> int:
    """Delete the kernels that this copy of the package under this Python does not use; bytes that were freed."""
    found, freed = lots(place), 0
    for path in (path for kind in STALE for path in found[kind].paths):
        with suppress(OSError):
            size = path.lstat().st_size
            path.unlink()
            freed += size
            for folder in path.relative_to(place).parents[:-1]:  # the last one is the cache itself
                (place / folder).rmdir()  # if nothing else lies there
    return freed
