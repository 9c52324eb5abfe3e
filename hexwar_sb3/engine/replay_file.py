"""The bytes of a replay file `*.hwr`: zstd-compressed JSON lines, and no more of them than a game has.

A file from a stranger may be anything: too large, cut short, a bomb, not zstd, not JSON. Each
gets a `ReplayFileError` that names the place; nothing is half loaded.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import zstandard

from hexwar_sb3.errors import ConfigError, ReplayFileError
from hexwar_sb3.files import replacing
from hexwar_sb3.reading import parse_json, read_bytes

Line: TypeAlias = dict[str, Any]

SUFFIX = ".hwr"
UNDER_WAY = f".partial{SUFFIX}"  # a game that a person plays, which is no replay yet (formats/play.md)

MAX_FILE_BYTES = 4_000_000  # a whole game has about 40,000
MAX_TEXT_BYTES = 1 << 24  # after decompression; a whole game has about 100,000, and the longest some millions
MAX_LINES = 50_000  # a whole game has about 700
MAX_LINE_BYTES = 1 << 20  # the head of the largest map has about 60,000
_CHUNK_BYTES = 256  # packed; a bomb unpacks to at most some megabytes a chunk
_LEVEL = 19  # of compression: written once, read often
_MAGIC = b"\x28\xb5\x2f\xfd"


def replays_in(folder: Path) -> list[Path]:
    """The replays of a folder and of those in it, in the order of their names, without games under way."""
    return sorted(path for path in folder.rglob(f"*{SUFFIX}") if not path.name.endswith(UNDER_WAY))


def replays_of(path: Path) -> list[Path]:
    """A replay, or those of a folder.

    Raises:
        ConfigError: there is none in the folder.
    """
    found = replays_in(path) if path.is_dir() else [path]
    if not found:
        raise ConfigError(f"{path} holds no replay (*{SUFFIX})")
    return found


def write_lines(path: Path, lines: Sequence[Line]) -> None:
    """Write a file whole or not at all.

    Raises:
        ReplayFileError: nobody could read it, it is too large.
    """
    packed = packed_lines(lines, path)
    with replacing(path) as temporary:
        temporary.write_bytes(packed)


def packed_lines(lines: Sequence[Line], path: Path = Path("replay")) -> bytes:
    """The bytes of a file.

    Raises:
        ReplayFileError: nobody could read it, it is too large.
    """
    text = b"".join(_encoded(line) for line in lines)
    if len(text) > MAX_TEXT_BYTES:
        fail(path, "file", f"{len(text)} bytes to write", f"at most {MAX_TEXT_BYTES}")
    return zstandard.ZstdCompressor(level=_LEVEL, write_checksum=True).compress(text)


def content_hash(lines: Sequence[Line]) -> str:
    """Hash of some lines as they stand in a file."""
    digest = hashlib.sha256()
    for line in lines:
        digest.update(_encoded(line))
    return digest.hexdigest()


def _encoded(line: Line) -> bytes:
    return json.dumps(line, separators=(",", ":"), ensure_ascii=False).encode() + b"\n"


def read_lines(path: Path) -> Iterator[Line]:
    """The lines of a file, one by one.

    Raises:
        ReplayFileError: not a readable replay file; says where and why.
    """
    text = _unpacked(path, _packed(path))
    if not text.endswith(b"\n"):
        fail(path, f"byte {len(text)}", "the end of the file within a line", "a whole last line")
    n_lines = text.count(b"\n")
    if n_lines > MAX_LINES:
        fail(path, "file", f"{n_lines} lines", f"at most {MAX_LINES}")
    for number, line in enumerate(text.split(b"\n")[:-1], start=1):
        if len(line) > MAX_LINE_BYTES:
            fail(path, f"line {number}", f"{len(line)} bytes", f"at most {MAX_LINE_BYTES}")
        value = parse_json(line, path, "an object", ReplayFileError, f"line {number}")
        if not (isinstance(value, dict) and isinstance(value.get("type"), str)):
            fail(path, f"line {number}", str(line[:40]), 'an object with a "type"')
        yield value


def fail(path: Path, place: str, found: str, expected: str) -> NoReturn:
    """Refuse the file."""
    raise ReplayFileError(path, place, found=found, expected=expected)


def _packed(path: Path) -> bytes:
    packed = read_bytes(path, MAX_FILE_BYTES, ReplayFileError)
    if not packed.startswith(_MAGIC):
        fail(path, "byte 0", repr(packed[: len(_MAGIC)]), "a zstd-compressed file")
    return packed


def _unpacked(path: Path, packed: bytes) -> bytes:
    """The text; given up as soon as it is longer than any game's."""
    unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_TEXT_BYTES).decompressobj()
    text = bytearray()
    for start in range(0, len(packed), _CHUNK_BYTES):
        try:
            text += unpacker.decompress(packed[start : start + _CHUNK_BYTES])
        except zstandard.ZstdError as problem:
            place = f"byte {len(text)} unpacked"
            raise ReplayFileError(path, place, found=str(problem), expected="whole zstd data") from problem
        if len(text) > MAX_TEXT_BYTES:
            fail(path, "file", f"more than {MAX_TEXT_BYTES} bytes unpacked", "one game")
    if not unpacker.eof or unpacker.unused_data:
        fail(path, f"byte {len(packed)}", "no end of the zstd data there", "one whole zstd frame")
    return bytes(text)
