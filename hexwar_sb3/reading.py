"""Reading what may come from a stranger: counted bytes of regular files, strict JSON, archives without surprises.

Whatever is checked is read once: the bytes that were checked are the bytes that are used. Nothing here unpickles.
A file of at most 4 MB is answered in seconds and in some 100 MB, whatever it holds.
"""

from __future__ import annotations

import io
import json
import math
import os
import stat
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import prod
from pathlib import Path
from tokenize import TokenError
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from hexwar_sb3.errors import FileFormatError

MAX_JSON_BYTES = 1 << 22
MAX_DEPTH = 100  # of JSON's lists and objects within each other
MAX_CONTAINERS = 200_000  # lists and objects
MAX_DIGITS = 40  # of a whole number in JSON; the state of a random generator has 39
MAX_ENTRIES = 4_096  # of an archive
UNPACKED_BYTES, UNPACKED_RATIO = (
    1 << 24,
    16,
)  # an archive may unpack to so many bytes, and so many for each of its own
_MAX_AXES = 16
_CHUNK_BYTES = 1 << 20
_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}

_BROKEN = (
    *(zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error, OSError, EOFError, ValueError),
    *(
        LookupError,
        TokenError,
        TypeError,
        AttributeError,
        ArithmeticError,
        RuntimeError,
        MemoryError,
        SyntaxError,
        tokenize.TokenError,
        Warning,
    ),
)
"""What the readers of Python and numpy raise over broken archives and arrays."""

Error = type[FileFormatError]


@contextmanager
def opened(
    path: Path, error: Error = FileFormatError, expected: str = "a readable file"
) -> Iterator[BinaryIO]:
    """Open a regular file for reading; a pipe, a device or a folder is refused instead of waited for.

    Raises:
        FileFormatError: of the type `error`; it is missing, not readable or no regular file.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, flags)
    except (OSError, ValueError) as problem:  # ValueError: a NUL in the path
        found = getattr(problem, "strerror", None) or str(problem)
        raise error(path, "file", found=found, expected=expected) from problem
    mode = os.fstat(handle).st_mode
    if not stat.S_ISREG(mode):
        os.close(handle)
        found = "Is a directory" if stat.S_ISDIR(mode) else "a pipe or a device"
        raise error(path, "file", found=found, expected=expected)
    with os.fdopen(handle, "rb") as file:
        yield file


def read_bytes(
    path: Path, most: int, error: Error = FileFormatError, expected: str = "a readable file"
) -> bytes:
    """Read a regular file of at most so many bytes, counted as they come.

    Raises:
        FileFormatError: of the type `error`; it is missing, no regular file, or larger.
    """
    with opened(path, error, expected) as file:
        try:
            data = file.read(most + 1)
        except OSError as problem:
            raise error(path, "file", found=str(problem), expected=expected) from problem
    if len(data) > most:
        raise error(path, "file size", found=f"more than {most} bytes", expected=f"at most {most}")
    return data


def read_json(
    path: Path, expected: str = "names and values", error: Error = FileFormatError, most: int = MAX_JSON_BYTES
) -> dict[str, Any]:
    """Read a JSON object.

    Args:
        path: of the file.
        expected: what it should be, in words.
        error: type of the error.
        most: bytes that it may have.

    Raises:
        FileFormatError: it is missing, too large or broken, or names something twice.
    """
    values = parse_json(read_bytes(path, most, error, expected), path, expected, error)
    if not isinstance(values, dict):
        raise error(path, "file", found=type(values).__name__, expected=expected)
    return values


def parse_json(
    data: bytes | str, source: str | Path, expected: str, error: Error = FileFormatError, place: str = "text"
) -> Any:
    """Read JSON in UTF-8: finite numbers, every name once, no endless nesting, in time linear in its length.

    Raises:
        FileFormatError: of the type `error`; it is none.
    """
    try:
        text = data.decode("utf-8") if isinstance(data, bytes) else data
        value = _DECODER.decode(_few(text))
        if "\\ud" in text.lower():
            json.dumps(value, ensure_ascii=False).encode()  # half of a character, which nobody can print
    except json.JSONDecodeError as problem:
        where = f"{place}, line {problem.lineno}, column {problem.colno}"
        raise error(source, where, found=problem.msg, expected=f"{expected} as JSON") from problem
    except (ValueError, RecursionError) as problem:
        raise error(source, place, found=str(problem), expected=f"{expected} as JSON in UTF-8") from problem
    if _is_deep(value):
        raise error(source, place, found=f"more than {MAX_DEPTH} levels", expected=f"{expected} as JSON")
    return value


def _few(text: str) -> str:
    if text.count("[") + text.count("{") > MAX_CONTAINERS:
        raise ValueError(f"more than {MAX_CONTAINERS} lists and objects")
    return text


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        known: set[str] = set()
        for name, _ in pairs:
            if name in known:
                raise ValueError(f"the key {name[:60]!r} twice")
            known.add(name)
    return values


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant}, which is no number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"the number {text[:60]}, which is not finite")
    return value


def _whole(text: str) -> int:
    if len(text) > MAX_DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text)


_DECODER = json.JSONDecoder(
    object_pairs_hook=_once, parse_constant=_refuse, parse_float=_finite, parse_int=_whole
)


def _is_deep(value: Any) -> bool:
    level = [value]
    for _ in range(MAX_DEPTH):
        level = [
            child
            for one in level
            if isinstance(one, dict | list)
            for child in (one.values() if isinstance(one, dict) else one)
            if isinstance(child, dict | list)
        ]
        if not level:
            return False
    return True


@contextmanager
def archive(
    file: bytes | BinaryIO, source: str | Path, error: Error, expected: str
) -> Iterator[zipfile.ZipFile]:
    """Open a zip after a look at its list: few entries of different names, plain ways to pack, sizes that a file can hold.

    Whatever goes wrong in the block while entries are read is told as an error of the file, too.

    Args:
        file: the bytes, or an open file at its beginning.
        source: its name in messages.
        error: type of the error.
        expected: what it should be, in words.

    Raises:
        FileFormatError: of the type `error`; it is no such archive.
    """
    try:
        stream = io.BytesIO(file) if isinstance(file, bytes) else file
        size = stream.seek(0, os.SEEK_END)
        stream.seek(0)
        with zipfile.ZipFile(stream) as opened_zip:
            _check_list(opened_zip, size, source, error)
            yield opened_zip
    except FileFormatError:
        raise
    except _BROKEN as problem:
        found = str(problem) or type(problem).__name__
        raise error(source, "file", found=found, expected=expected) from problem


def _check_list(opened_zip: zipfile.ZipFile, size: int, source: str | Path, error: Error) -> None:
    entries = opened_zip.infolist()
    if len(entries) > MAX_ENTRIES:
        raise error(source, "file", found=f"{len(entries)} entries", expected=f"at most {MAX_ENTRIES}")
    names = {entry.filename for entry in entries}
    if len(names) < len(entries):
        raise error(source, "file", found="two entries of one name", expected="each name once")
    for entry in entries:
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or entry.flag_bits & 1:
            raise error(source, entry.filename, found="packed in another way", expected="stored or deflated")
    stored = sum(entry.file_size for entry in entries if entry.compress_type == zipfile.ZIP_STORED)
    if stored > size:
        raise error(
            source, "file", found=f"entries of {stored} bytes", expected=f"at most the file's own {size}"
        )
    unpacked = sum(entry.file_size for entry in entries)
    most = UNPACKED_BYTES + UNPACKED_RATIO * size
    if unpacked > most:
        raise error(source, "file", found=f"{unpacked} bytes unpacked", expected=f"at most {most}")


def read_arrays(
    file: bytes | BinaryIO,
    source: str | Path,
    error: Error = FileFormatError,
    expected: str = "arrays (.npz)",
) -> dict[str, NDArray[Any]]:
    """Read all arrays of a `.npz`, without pickle; memory is taken for what lies in the file, and no more.

    Raises:
        FileFormatError: of the type `error`; it is broken, or an array holds objects.
    """
    with archive(file, source, error, expected) as entries:
        for name in entries.namelist():
            if not name.endswith(".npy"):
                raise error(source, name, found="an entry that is no array", expected=expected)
        return {
            entry.filename.removesuffix(".npy"): _array(entries, entry, source, error)
            for entry in entries.infolist()
        }


def _array(
    entries: zipfile.ZipFile, entry: zipfile.ZipInfo, source: str | Path, error: Error
) -> NDArray[Any]:
    def fail(found: str, expected: str) -> NoReturn:
        raise error(source, entry.filename, found=found, expected=expected)

    with entries.open(entry) as stream:
        version = npy.read_magic(stream)
        if version not in _HEADERS:
            fail(f"version {version} of .npy", "1.0 or 2.0")
        with warnings.catch_warnings(action="error"):
            shape, fortran, dtype = _HEADERS[version](stream)
        if dtype.hasobject or not dtype.itemsize or dtype != dtype.newbyteorder("="):
            fail(
                f"values of the type {dtype}",
                "plain ones of this machine; objects would have to be unpickled",
            )
        if len(shape) > _MAX_AXES or any(type(n) is not int or n < 0 for n in shape):
            fail(f"the shape {shape}", "lengths of axes")
        size = prod(shape) * dtype.itemsize
        if size != entry.file_size - stream.tell():
            fail(f"{entry.file_size - stream.tell()} bytes", f"{size}, for {dtype} {shape}")
        if prod(max(n, 1) for n in shape) * dtype.itemsize > UNPACKED_RATIO * (
            entry.file_size + UNPACKED_BYTES
        ):
            fail(f"the shape {shape}", "lengths that a file can fill")
        flat = np.empty(prod(shape), dtype)
        _fill(memoryview(flat.view(np.uint8).data) if size else memoryview(b""), stream)
        if stream.read(1):
            fail("more bytes", f"{size}")
    return flat.reshape(shape, order="F" if fortran else "C")


def _fill(room: memoryview, stream: Any) -> None:
    """Read as many bytes as there is room for; at the end the entry's checksum is compared."""
    for start in range(0, len(room), _CHUNK_BYTES):
        part = room[start : start + _CHUNK_BYTES]
        data = stream.read(len(part))
        if len(data) != len(part):
            raise EOFError("the file ends within an array")
        part[:] = data


def read_entries(
    file: bytes | BinaryIO, source: str | Path, error: Error = FileFormatError, expected: str = "a zip"
) -> dict[str, bytes]:
    """Read all entries of a zip.

    Raises:
        FileFormatError: of the type `error`; it is broken.
    """
    with archive(file, source, error, expected) as entries:
        return {entry.filename: _entry(entries, entry) for entry in entries.infolist()}


def _entry(entries: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """The bytes of an entry, as many as it is said to have; read whole, it inflates to whatever is in it."""
    with entries.open(entry) as stream:
        data = stream.read(entry.file_size)
        if len(data) != entry.file_size or stream.read(1):  # at the end the checksum is compared
            raise EOFError(f"{entry.filename} is not {entry.file_size} bytes long")
    return data


def check_names(
    values: Mapping[str, Any], known: Mapping[str, Any], source: str | Path, error: Error = FileFormatError
) -> None:
    """Refuse names that are not known.

    Raises:
        FileFormatError: of the type `error`; with the first of them.
    """
    for name in values:
        if name not in known:
            raise error(source, name, found="an unknown name", expected=f"some of {', '.join(known)}")
