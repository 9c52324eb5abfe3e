"""Jobs for other machines: a call with the files that it reads goes there, what it leaves comes back as bytes.

In a spec a `Path` is a file or a folder. One that is there travels with the job; the folders around it do not. A worker
has them in a temporary folder, at the same places below it, and works there as it would here. A text stays a text.
"""

from __future__ import annotations

import hashlib
import io
import platform
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from pickle import Unpickler
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any, TypeAlias

import cloudpickle

import hexwar_sb3
from hexwar_sb3.bots.config import bots_hash
from hexwar_sb3.bots.registry import is_bot
from hexwar_sb3.errors import ClusterError, ConfigError, FileFormatError, HexWarError, shortened
from hexwar_sb3.files import UNFINISHED, replacing
from hexwar_sb3.folders import LOCK, making
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.scenario import Scenario, ScenarioLike
from hexwar_sb3.players.player import POLICIES
from hexwar_sb3.processes import keep_memory
from hexwar_sb3.rules import default_rules
from hexwar_sb3.version import __version__

MOST_BYTES = 1 << 28  # of what one path brings along, or one job leaves
LIBRARIES = ("numpy", "numba", "torch")  # of whose versions results depend
POLICY = ("policy", "config.json")  # in a run's folder: its policy is all that travels of it
Files: TypeAlias = "Mapping[str, bytes]"  # of a folder by their names in it; a file alone has none: ""
Leaves: TypeAlias = "Callable[[Any], Iterable[Path]]"


def as_place(player: object) -> object:
    """A player as a spec names it, so that a policy's file or folder travels."""
    if not isinstance(player, str) or player in POLICIES or is_bot(player):
        return player
    return Path(player)


def at_hand(scenario: ScenarioLike) -> ScenarioLike:
    """A scenario as a spec holds it: a name, or what its file says.

    Raises:
        ScenarioFileError, MapFileError: the file cannot be used.
    """
    if isinstance(scenario, Scenario) or not str(scenario).endswith(".json"):
        return scenario
    return load_scenario(scenario)


def nothing(_: object) -> Iterable[Path]:
    """Leaves no files."""
    return ()


@dataclass(frozen=True, kw_only=True)
class Parcel:
    """A job on its way."""

    program: Mapping[str, str]  # that packed it
    call: bytes  # function, spec, and what the spec leaves


@dataclass(frozen=True, kw_only=True)
class Result:
    """What comes back."""

    host: str  # that it comes from
    seconds: float = 0.0  # of its processor
    made: Any = None  # that the function returned
    files: Sequence[Files | None] = ()  # by the paths that the spec leaves; None: there is nothing
    error: HexWarError | None = None


@cache
def program() -> Mapping[str, str]:
    """What results depend on beside their specs: versions and hashes that must be the same on all machines."""
    root, digest = Path(hexwar_sb3.__file__).parent, hashlib.sha256()
    for path in sorted([*root.glob("*.py"), *root.glob("*/*.py")]):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return {
        "hexwar_sb3": __version__,
        "rules": default_rules().hash,
        "bots": bots_hash(),
        "sources": digest.hexdigest()[:16],
        "Python": ".".join(platform.python_version_tuple()[:2]),
        **{name: version(name).partition("+")[0] for name in LIBRARIES},
    }


def pack(function: Callable[[Any], Any], spec: object, leaves: Leaves = nothing) -> Parcel:
    """Pack a call, and the files that its spec names.

    Raises:
        ConfigError: a file or folder is too large to travel.
    """
    file = io.BytesIO()
    _Packer(file, [path.absolute() for path in leaves(spec)]).dump((function, spec, leaves))
    return Parcel(program=program(), call=file.getvalue())


class _Packer(cloudpickle.Pickler):  # type: ignore[misc]  # it has no types
    """Pickles paths as where they are, and the files that are there.

    Args:
        file: that it writes into.
        left: paths that the job leaves; they and the folders around them are named alone.
    """

    def __init__(self, file: io.BytesIO, left: Sequence[Path]) -> None:
        super().__init__(file)
        self.left = left

    def persistent_id(self, thing: object) -> tuple[tuple[str, ...], Files | None] | None:
        """A path's parts and files; None for everything else."""
        if not isinstance(thing, Path):
            return None
        place = thing.absolute()
        is_around = any(place == path or place in path.parents for path in self.left)
        part = POLICY[0] if place.joinpath(*POLICY).is_file() else ""
        return place.parts[1:], None if is_around else files_of(place, part)


class _Unpacker(Unpickler):
    """Lays files out below a folder, and gives their paths there."""

    def __init__(self, file: io.BytesIO, root: Path) -> None:
        super().__init__(file)
        self.root = root

    def persistent_load(self, known: tuple[tuple[str, ...], Files | None]) -> Path:
        """The path of a thing that came along."""
        parts, files = known
        place = self.root.joinpath(*parts)
        if files is not None and not place.exists():
            leave(files, place)
        return place


def files_of(place: Path, part: str = "") -> Files | None:
    """The files of a path, or of a part of a folder; None if nothing is there.

    Raises:
        ConfigError: they are too many bytes.
    """
    if place.is_file():
        paths = [place]
    elif place.is_dir():
        found = sorted(place.joinpath(part).rglob("*"))
        paths = [path for path in found if path.is_file() and _is_whole(path, place)]
    else:
        return None
    if sum(path.stat().st_size for path in paths) > MOST_BYTES:
        raise ConfigError(f"{place} has more than {MOST_BYTES >> 20} MB: too much to travel with a job")
    return {"" if path == place else path.relative_to(place).as_posix(): path.read_bytes() for path in paths}


def _is_whole(path: Path, place: Path) -> bool:
    """Whether a file belongs to a folder, and is not a lock or half written."""
    return path.name != LOCK and not any(
        part.startswith(UNFINISHED) for part in path.relative_to(place).parts
    )


def leave(files: Files, place: Path) -> None:
    """Write files that came from elsewhere, all of them at once or none.

    Raises:
        ClusterError: they are no files, or one lies outside of the folder.
        OSError: they cannot be written.
    """
    for name in files:
        if ".." in PurePosixPath(name).parts or name.startswith("/") or "\\" in name:
            raise ClusterError(
                f"{place}: a worker sent {shortened(repr(name))}; expected files of this folder"
            )
    if "" in files:
        with replacing(place) as temporary:
            temporary.write_bytes(files[""])
        return
    with making(place) as made:
        for name, data in files.items():
            (made / name).parent.mkdir(parents=True, exist_ok=True)
            (made / name).write_bytes(data)


def work(parcel: Parcel) -> Result:
    """Unpack a job, do it and pack what came of it: what a worker on another machine runs."""
    host = socket.gethostname()
    differing = [name for name, found in program().items() if parcel.program.get(name) != found]
    if differing:
        name = differing[0]
        found, expected = program()[name], parcel.program.get(name)
        return Result(
            host=host, error=ClusterError(f"{host}: found {name} {found}; expected {expected}, as here")
        )
    keep_memory()
    start = process_time()
    with TemporaryDirectory(prefix="hexwar_sb3-job-", ignore_cleanup_errors=True) as folder:
        root = Path(folder).resolve()
        try:
            function, spec, leaves = _Unpacker(io.BytesIO(parcel.call), root).load()
            made = function(spec)
            files = [files_of(path) for path in leaves(spec)]
        except Exception as error:  # noqa: BLE001  whatever it is, it is told where somebody reads
            return Result(host=host, error=_told(error, root, host))
        return Result(host=host, seconds=process_time() - start, made=made, files=files)


def _told(error: Exception, root: Path, host: str) -> HexWarError:
    """An error as it is raised where the job came from: with the paths that are known there."""

    def known(text: str) -> str:
        return text.replace(str(root), "")

    if isinstance(error, FileFormatError):
        return type(error)(known(error.path), error.place, found=known(error.found), expected=error.expected)
    if isinstance(error, HexWarError):
        return error
    lines: Iterator[str] = filter(None, str(error).splitlines())
    return ClusterError(f"{host}: {type(error).__name__}: {shortened(known(next(lines, 'no message')))}")
