"""What a stranger's bytes may do to a reader: nothing but an error with file and place, soon, in little memory."""

from __future__ import annotations

import io
import os
import pickle
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib import format as npy

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.files import write_json
from hexwar_sb3.reading import (
    MAX_CONTAINERS,
    MAX_DEPTH,
    MAX_JSON_BYTES,
    parse_json,
    read_arrays,
    read_bytes,
    read_entries,
    read_json,
)

SECONDS, MEGABYTES = 2.0, 500.0  # in which a file of 4 MB is answered
LARGE = 4_000_000  # bytes

BROKEN = {
    "broken off": (b'{"a": ', r"text, line 1, column 7: found Expecting value; expected a page as JSON"),
    "nested without end": (b"[" * 100_000, "text: found maximum recursion depth"),
    "nested deeper than anything of ours": (b'{"a":' * 101 + b"1" + b"}" * 101, "text: found more than 100"),
    "no UTF-8": (b'{"a": "\xff"}', "text: found .*can't decode"),
    "UTF-16": ('{"a": 1}'.encode("utf-16"), "text: found .*can't decode"),
    "with a byte order mark": (b'\xef\xbb\xbf{"a": 1}', "column 1: found Expecting value"),
    "half a character": (b'{"a": "\\ud800"}', "text: found .*surrogates not allowed"),
    "a key twice": (b'{"a": {"b": 1, "b": 2}}', "text: found the key 'b' twice"),
    "not a number": (b'{"a": NaN}', "text: found NaN"),
    "an infinite number": (b'{"a": -Infinity}', "text: found -Infinity"),
    "too large for a float": (b'{"a": 1e999}', "text: found the number 1e999, which is not finite"),
    "too many digits": (b'{"a": ' + b"9" * 41 + b"}", "text: found a number of 41 digits"),
    "a list": (b"[1]", "file: found list; expected a page"),
    "too large": (b" " * (MAX_JSON_BYTES + 1), "file size: found more than 4194304 bytes"),
    "empty": (b"", "found Expecting value"),
}
COSTLY = {
    "keys": b"{" + b",".join(b'"%d":0' % k for k in range(320_000)) + b"}",
    "a key again and again": b"{" + b",".join([b'"a":0'] * 600_000) + b"}",
    "lists": b"[" + b"[]," * 1_300_000 + b"0]",
    "as many lists as there may be": b"[" + b"[]," * (MAX_CONTAINERS - 2) + b"0]",
    "numbers": b"[" + b"1," * 1_900_000 + b"1]",
    "fractions": b"[" + b"1.5," * 990_000 + b"1]",
    "one text": b'"' + b"x" * 3_900_000 + b'"',
    "escapes": b'"' + b"\\u0041" * 660_000 + b'"',
}


def test_an_object_comes_back(tmp_path: Path) -> None:
    write_json(tmp_path / "one.json", {"a": [1, None, "ä", 2**127]})

    assert read_json(tmp_path / "one.json") == {"a": [1, None, "ä", 2**127]}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_answered_with_file_and_place(what: str, tmp_path: Path) -> None:
    content, message = BROKEN[what]
    path = tmp_path / "one.json"
    path.write_bytes(content)

    with pytest.raises(FileFormatError, match=rf"one\.json: .*{message}"):
        read_json(path, "a page")


def test_json_of_the_greatest_depth_is_read() -> None:
    text = "[" * MAX_DEPTH + "]" * MAX_DEPTH

    assert parse_json(text, "file", "lists") is not None


@pytest.mark.parametrize("what", COSTLY)
def test_four_megabytes_of_json_are_answered_soon(what: str) -> None:
    """Read or refused: in time linear in the length, whatever they repeat."""

    def answer() -> None:
        try:
            parse_json(COSTLY[what], "file", "values")
        except FileFormatError:
            return

    assert len(COSTLY[what]) <= LARGE
    assert _seconds(answer) < SECONDS


def _seconds(function: Callable[[], object]) -> float:
    start = time.process_time()
    function()
    return time.process_time() - start


# --- what is no regular file -----------------------------------------------------------------------


def _odd_files(folder: Path) -> dict[str, Path]:
    os.mkfifo(folder / "pipe")
    for name, target in (("device", "/dev/zero"), ("loop", "loop"), ("to_pipe", "pipe")):
        (folder / name).symlink_to(target)
    (folder / "folder").mkdir()
    with (folder / "sparse").open("wb") as file:
        file.truncate(1 << 40)
    names = ("pipe", "device", "loop", "to_pipe", "folder", "sparse", "none", "a\0b", "x" * 300, "\udcff")
    return {name: folder / name for name in names}


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    for name, path in _odd_files(tmp_path).items():
        with pytest.raises(FileFormatError, match="expected") as raised:
            read_bytes(path, LARGE)

        assert str(raised.value).isprintable(), name


def test_bytes_are_counted_as_they_come() -> None:
    """The size that the file system tells is asked by nobody: files of /proc have none."""
    with pytest.raises(FileFormatError, match="more than 3 bytes"):
        read_bytes(Path("/proc/self/status"), 3)


# --- archives --------------------------------------------------------------------------------------


def _zip(entries: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return packed.getvalue()


def _npy(array: Any, *, objects: bool = False) -> bytes:
    written = io.BytesIO()
    np.save(written, array, allow_pickle=objects)
    return written.getvalue()


def _claimed(shape: tuple[int, ...]) -> bytes:
    """An array's head, and nothing after it."""
    written = io.BytesIO()
    npy.write_array_header_1_0(written, {"descr": "<i2", "fortran_order": False, "shape": shape})
    return written.getvalue()


def _zip_twice() -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.npy", GOOD_ARRAY)
        archive.writestr("b.npy", GOOD_ARRAY)
    return packed.getvalue().replace(b"b.npy", b"a.npy")


class Payload:
    """Says that it was unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return exec, ("raise SystemExit('unpickled')",)


def _patched(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new)


GOOD_ARRAY = _npy(np.arange(6, dtype=np.int16).reshape(2, 3))
GOOD = _zip({"a.npy": GOOD_ARRAY})


def bad_archives() -> dict[str, bytes]:
    """Archives of arrays that must be refused."""
    return {
        "no archive": b"nothing",
        "an array": GOOD_ARRAY,
        "empty": b"",
        "two entries of one name": _zip_twice(),
        "no array": _zip({"a.npy": b"nothing"}),
        "an entry of nothing": _zip({"a.npy": b""}),
        "objects": _zip({"a.npy": _npy(np.array([Payload()], object), objects=True)}),
        "a pickle": _zip({"a.npy": pickle.dumps(Payload())}),
        "a shape that nothing holds": _zip({"a.npy": _claimed((3, 10**13))}),
        "another shape": _zip({"a.npy": GOOD_ARRAY.replace(b"(2, 3)", b"(2, 4)")}),
        "a negative shape": _zip({"a.npy": GOOD_ARRAY.replace(b"(2, 3)", b"(-2,3)")}),
        "a shape of no numbers": _zip({"a.npy": GOOD_ARRAY.replace(b"(2, 3)", b"'abcd'")}),
        "rows of nothing, without end": _zip({"a.npy": _claimed((0, 10**13))}),
        "no type": _zip({"a.npy": GOOD_ARRAY.replace(b"'<i2'", b"'<q9'")}),
        "brackets without an end": _zip({"a.npy": GOOD_ARRAY.replace(b"(2, 3)", b"((((((")}),
        "code for a shape": _zip({"a.npy": GOOD_ARRAY.replace(b"(2, 3)", b"exit()")}),
        "fewer bytes": _zip({"a.npy": GOOD_ARRAY[:-1]}),
        "more bytes": _zip({"a.npy": GOOD_ARRAY + b"\0"}),
        "a wrong checksum": _patched(GOOD, GOOD_ARRAY[-4:], b"\1\2\3\4"),
        "a bomb": _zip({"a.npy": _npy(np.zeros(1 << 24))}, zipfile.ZIP_DEFLATED),
        "packed by another method": _zip({"a.npy": GOOD_ARRAY}, zipfile.ZIP_LZMA),
        "very many entries": _zip({f"{k}.npy": b"" for k in range(5_000)}),
        **{f"cut after {n} bytes": GOOD[:n] for n in range(1, len(GOOD), 17)},
    }


def test_an_archive_comes_back() -> None:
    packed = _zip({"a.npy": GOOD_ARRAY, "b.npy": _npy(np.asfortranarray(np.eye(3)))}, zipfile.ZIP_DEFLATED)

    arrays = read_arrays(packed, "file")

    assert arrays["a"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert arrays["b"].tolist() == np.eye(3).tolist()
    assert arrays["a"].flags.writeable


def test_a_bad_archive_is_refused_soon_and_in_little_memory() -> None:
    for what, data in bad_archives().items():
        tracemalloc.start()
        with pytest.raises(FileFormatError, match="expected"):
            read_arrays(data, "file")
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()

        assert peak < MEGABYTES / 2, what


def test_flipped_bits_give_the_arrays_or_an_error() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        data = bytearray(GOOD)
        data[rng.integers(len(data))] ^= 1 << rng.integers(8)
        try:
            arrays = read_arrays(bytes(data), "file")
        except FileFormatError:
            continue
        assert [array.tolist() for array in arrays.values()] in ([[[0, 1, 2], [3, 4, 5]]], [])


def test_entries_lie_within_the_file() -> None:
    """A list that names the same stored bytes again and again would unpack to any size."""
    entries = {f"{k}": b"x" * 1_000 for k in range(3)}
    packed = bytearray(_zip(entries))
    for k in (1, 2):  # all three begin where the first does
        at = packed.rindex(f"{k}".encode(), 0, len(packed))
        packed[at - 4 : at] = (0).to_bytes(4, "little")

    with pytest.raises(FileFormatError):
        read_entries(bytes(packed), "file")


def test_a_head_that_is_no_python_is_refused() -> None:
    """Its words are looked at by numpy, which stumbles over brackets that nobody closes."""
    for head in (b"(" * 100, b"{'descr': [", b"'" * 3, b"\\", b"\xff", b"\0"):
        data = bytearray(GOOD_ARRAY)
        data[10 : 10 + len(head)] = head

        with pytest.raises(FileFormatError, match="expected"):
            read_arrays(_zip({"a.npy": bytes(data)}), "file")


def test_numbers_of_another_byte_order_are_refused() -> None:
    for dtype in (">i4", [("a", ">f4"), ("b", "i1")]):
        with pytest.raises(FileFormatError, match="of this machine"):
            read_arrays(_zip({"a.npy": _npy(np.zeros(3, dtype))}), "file")
