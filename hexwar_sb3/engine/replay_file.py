"""The bytes of a replay file `*.hwr`: zstd-compressed JSON lines, and no more of them than a game has.

A file from a stranger may be anything: too large, cut short, a bomb, not zstd, not JSON. Each
gets a `ReplayFileError` that names the place; nothing is half loaded.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import zstandard

from hexwar_sb3.errors import ReplayFileError
from hexwar_sb3.files import replacing

Line: TypeAlias = dict[str, Any]

MAX_FILE_BYTES = 4_000_000  # a whole game has about 40,000
MAX_TEXT_BYTES = 64_000_000  # after decompression
MAX_LINES = 200_000
_CHUNK_BYTES = 256  # packed; a bomb unpacks to at most some megabytes a chunk
_LEVEL = 19  # of compression: written once, read often
_MAGIC = b"\x28\xb5\x2f\xfd"


def write_lines(path: Path, lines: Sequence[Line]) -> None:
    """Write a file whole or not at all."""
    text = b"".join(_encoded(line) for line in lines)
    packed = zstandard.ZstdCompressor(level=_LEVEL, write_checksum=True).compress(text)
    with replacing(path) as temporary:
        temporary.write_bytes(packed)


def content_hash(lines: Sequence[Line]) -> str:
    """Hash of some lines as they stand in a file."""
    digest = hashlib.sha256()
    for line in lines:
        digest.update(_encoded(line))
    return digest.hexdigest()


def _encoded(line: Line) -> bytes:
    return json.dumps(line, separators=(",", ":"), ensure_ascii=False).encode() + b"\n"


def read_lines(path: Path) -> list[Line]:
    """All lines of a file.

    Raises:
        ReplayFileError: not a readable replay file; says where and why.
    """
    text = _unpacked(path, _packed(path))
    if not text.endswith(b"\n"):
        fail(path, f"byte {len(text)}", "the end of the file within a line", "a whole last line")
    lines = text.split(b"\n")[:-1]
    if len(lines) > MAX_LINES:
        fail(path, "file", f"{len(lines)} lines", f"at most {MAX_LINES}")
    return [_parsed(path, number, line) for number, line in enumerate(lines, start=1)]


def fail(path: Path, place: str, found: str, expected: str) -> NoReturn:
    """Refuse the file."""
    raise ReplayFileError(path, place, found=found, expected=expected)


def _packed(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            packed = file.read(MAX_FILE_BYTES + 1)
    except OSError as problem:
        found = problem.strerror or type(problem).__name__
        raise ReplayFileError(path, "file", found=found, expected="a readable file") from problem
    if not packed.startswith(_MAGIC):
        fail(path, "byte 0", repr(packed[: len(_MAGIC)]), "a zstd-compressed file")
    if len(packed) > MAX_FILE_BYTES:
        fail(path, "file", f"more than {MAX_FILE_BYTES} bytes", f"at most {MAX_FILE_BYTES}")
    return packed


def _unpacked(path: Path, packed: bytes) -> bytes:
    """The text; given up as soon as it is longer than any game's."""
    text, unpacker = bytearray(), zstandard.ZstdDecompressor().decompressobj()
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


def _parsed(path: Path, number: int, line: bytes) -> Line:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError) as problem:
        raise ReplayFileError(path, f"line {number}", found=str(problem), expected="JSON") from problem
    if not (isinstance(value, dict) and isinstance(value.get("type"), str)):
        fail(path, f"line {number}", str(line[:40]), 'an object with a "type"')
    return value
