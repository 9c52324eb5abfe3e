"""Arrays by others: objects, types, shapes, values field by field, headers that lie."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.lib import format as npy

from tests.attack.archives import from_npy, object_array, to_npy, unzipped
from tests.attack.tricks import Lens, Trick, Tricks, entry, instead
from tests.attack.tricks_json import json_tricks

DTYPES = ("?", "i1", "i8", "u8", ">i4", "f2", "f4", "f8", ">f8", "g", "c8", "c16", "U3", "S3", "M8[s]", "V7")
HEADERS = {
    "10^12 rows": (f"({10**12},)", None),
    "10^9 rows of nothing": (f"({10**9}, 0)", None),
    "rows of 0 bytes": (f"({10**12},)", "'|V0'"),
    "-1 rows": ("(-1,)", None),
    "half a row": ("(0.5,)", None),
    "2^63 rows": (f"({2**63},)", None),
    "deep rows": ("(" * 3000, None),
    "a call": ("(print(1),)", None),
    "objects in the header": ("(1,)", "'|O'"),
    "a wide text": ("()", f"'<U{10**9}'"),
}
"""Shape and type, as the header says them; None: the array's own."""


def npz_tricks(data: bytes) -> Tricks:
    """Every array of a `.npz`, and what JSON there is in one."""
    for name, body in unzipped(data).items():
        lens, array = entry(name), from_npy(body)
        yield from lens.lifted(npy_tricks, data)
        if array.ndim == 0 and array.dtype.kind == "U" and str(array).startswith("{"):
            text = Lens("text", _text_of, _with_text)
            yield from lens.lifted(partial(text.lifted, json_tricks), data)


def _text_of(body: bytes) -> bytes:
    return str(from_npy(body)).encode("utf-8", "surrogatepass")


def _with_text(_: bytes, text: bytes) -> bytes:
    return to_npy(np.array(text.decode("utf-8", "surrogateescape")))


def npy_tricks(body: bytes) -> Tricks:
    """One array by others."""
    array = from_npy(body)
    for name, make in _other_shapes(array):
        yield Trick("array shape", name, partial(_remade, make))
    for dtype in DTYPES:
        if np.dtype(dtype) != array.dtype:
            yield Trick("array type", f"as {dtype}", partial(_as_type, dtype))
    yield Trick("pickle", "objects", partial(instead, object_array()))
    for name, (shape, descr) in HEADERS.items():
        yield Trick("array header", name, partial(_with_header, shape, descr))
    for version in (b"\3\0", b"\x09\x09"):
        yield Trick("array header", f"version {version!r}", partial(_patched, 6, version))
    yield Trick("array header", "said 64 kB long", partial(_patched, 8, b"\xff\xff"))
    yield Trick("array header", "said 2 GB long", partial(_patched, 6, b"\2\0\xff\xff\xff\x7f"))
    yield Trick("array header", "cut by a byte", lambda d: d[:-1])
    yield Trick("array header", "a byte more", lambda d: d + b"\0")
    yield from _value_tricks(array)


def _value_tricks(array: Any) -> Tricks:
    """Every field to both ends of its type, in the first row or in all."""
    for field in array.dtype.names or ("",):
        for name, value in _ends(array.dtype[field] if field else array.dtype):
            for where in ("first", "all"):
                make = partial(_with_values, field, where == "all", value)
                yield Trick("array value", f"{field} {where} {name}".strip(), make)


def _other_shapes(array: Any) -> Iterator[tuple[str, Callable[[Any], Any]]]:
    yield "scalar", lambda a: np.zeros((), a.dtype)
    yield "empty", lambda a: a.reshape(-1)[:0]
    yield "an axis more", lambda a: a[None]
    yield "flat", lambda a: a.reshape(-1)
    yield "twice", lambda a: np.concatenate([a.reshape(-1)] * 2)
    if array.ndim:
        yield "a row less", lambda a: a[:-1]
        yield "a row more", lambda a: np.concatenate([a, a[-1:]])
        yield "no rows", lambda a: a[:0]
        yield "one row", lambda a: a[:1]
    if array.ndim > 1:
        yield "a column less", lambda a: a[:, :-1]
        yield "turned over", lambda a: a.T
        yield "in Fortran's order", np.asfortranarray


def _remade(make: Callable[[Any], Any], body: bytes) -> bytes:
    return to_npy(make(from_npy(body)))


def _as_type(dtype: str, body: bytes) -> bytes:
    array = from_npy(body)
    if np.dtype(dtype).kind == "V" or array.dtype.names:
        return to_npy(np.zeros(array.shape, dtype))
    try:
        with warnings.catch_warnings(action="ignore"):
            return to_npy(array.astype(dtype))
    except (TypeError, ValueError):
        return to_npy(np.zeros(array.shape, dtype))


def _patched(at: int, value: bytes, body: bytes) -> bytes:
    return body[:at] + value + body[at + len(value) :]


def _with_header(shape: str, descr: str | None, body: bytes) -> bytes:
    descr = descr or repr(npy.dtype_to_descr(from_npy(body).dtype))
    head = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}".encode("latin-1")
    head += b" " * (63 - (10 + len(head)) % 64) + b"\n"
    start = 10 + struct.unpack_from("<H", body, 8)[0]
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head + body[start:]


def _ends(dtype: np.dtype[Any]) -> list[tuple[str, Any]]:
    """Values that a type has, and perhaps no array should."""
    base = dtype.base
    if base.kind in "iu":
        info, sign = np.iinfo(base), -1 if base.kind == "i" else 1
        return [("lowest", info.min), ("highest", info.max), ("one off", sign), ("100", 100), ("0", 0)]
    if base.kind == "f":
        return [("NaN", np.nan), ("inf", np.inf), ("highest", np.finfo(base).max), ("-1e4", -1e4), ("0", 0.0)]
    if base.kind == "b":
        return [("true", True), ("false", False)]
    if base.kind == "U":
        return [("x", "x"), ("empty", ""), ("braces", "{}"), ("NUL", "a\0b")]
    return []


def _with_values(field: str, in_all: bool, value: Any, body: bytes) -> bytes:
    array = np.array(from_npy(body))
    target = array[field] if field else array
    if target.size:
        with warnings.catch_warnings(action="ignore"):
            target[... if in_all else (0,) * target.ndim] = value
    return to_npy(array)
