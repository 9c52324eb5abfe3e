"""Weights that are none: headers of safetensors that lie, numbers that are none, pickles."""

from __future__ import annotations

import json
import math
import struct
from functools import partial
from typing import Any

from tests.attack.archives import payloads, unzipped, with_entry, zipped
from tests.attack.tricks import Lens, Make, Trick, Tricks, byte_tricks, entry
from tests.attack.tricks_json import whole_tricks

DTYPES = ("I32", "U32", "BF16", "F16", "F64", "C64", "I64", "BOOL", "U8", "X", "")


def safetensors_tricks(data: bytes) -> Tricks:
    """The header by others, and its arrays one by one."""
    size = _head_size(data)
    head = json.loads(data[8 : 8 + size])
    for length in (0, 1, size - 1, size + 1, 2**31, 2**40, 2**63, 2**64 - 1):
        yield Trick("weights header", f"said {length} long", partial(_said_long, length))
    names = [name for name in head if name != "__metadata__"]
    for name in dict.fromkeys(names[:1] + names[-1:]):
        yield from _array_tricks(name, head[name])
    for name in names:
        for number in (math.nan, math.inf, -math.inf, 1e38, -1.0):
            make = partial(_with_number, head[name]["data_offsets"][0], number)
            yield Trick("weights value", f"{name} {number}", make)
    for dtype in ("I32", "BOOL"):
        yield Trick("weights header", f"all as {dtype}", partial(_all_as, dtype))
    more: dict[str, dict[str, Any]] = {
        "__metadata__": {"format": "x" * 1000},
        "zz": {"dtype": "F32", "shape": [0], "data_offsets": [0, 0]},
    }
    for name, value in more.items():
        yield Trick("weights header", f"and {name}", partial(_changed, name, value))
    yield Trick(
        "weights header",
        "its names twice",
        lambda d: _rewritten(d, lambda text: text[:-1] + b", " + text[1:]),
    )
    yield Trick("weights header", "60,000 arrays", lambda d: _rewritten(d, _many_arrays))
    yield Trick("weights value", "an array more", lambda d: d + bytes(4))
    yield from Lens("header", lambda d: d[8 : 8 + _head_size(d)], _with_head).lifted(whole_tricks, data)


def _array_tricks(name: str, known: dict[str, Any]) -> Tricks:
    start, end = known["data_offsets"]
    for dtype in DTYPES:
        yield Trick("weights header", f"{name} as {dtype}", partial(_changed, name, {"dtype": dtype}))
    for shape in ([], [-1], [2**63], [10**12], [0], [1], "x", None, [*known["shape"][::-1], 1]):
        yield Trick(
            "weights header", f"{name} of the shape {shape}", partial(_changed, name, {"shape": shape})
        )
    for offsets in ([start, end + 4], [end, start], [0, 2**63], [-4, end], [start], [start + 4, end], []):
        make = partial(_changed, name, {"data_offsets": offsets})
        yield Trick("weights header", f"{name} at {offsets}", make)
    yield Trick("weights header", f"no {name}", partial(_changed, name, None))


def _head_size(data: bytes) -> int:
    return int(struct.unpack("<Q", data[:8])[0])


def _said_long(length: int, data: bytes) -> bytes:
    return struct.pack("<Q", length) + data[8:]


def _with_head(data: bytes, text: bytes) -> bytes:
    return struct.pack("<Q", len(text)) + text + data[8 + _head_size(data) :]


def _rewritten(data: bytes, make: Make) -> bytes:
    return _with_head(data, make(data[8 : 8 + _head_size(data)].strip()))


def _many_arrays(text: bytes) -> bytes:
    more = ", ".join(f'"z{k}": {{"dtype":"F32","shape":[0],"data_offsets":[0,0]}}' for k in range(60_000))
    return text[:1] + more.encode() + b", " + text[1:]


def _changed(name: str, changes: dict[str, Any] | None, data: bytes) -> bytes:
    def make(text: bytes) -> bytes:
        head = json.loads(text)
        if changes is None:
            del head[name]
        else:
            head[name] = {**head.get(name, {}), **changes}
        return json.dumps(head).encode()

    return _rewritten(data, make)


def _all_as(dtype: str, data: bytes) -> bytes:
    return _rewritten(data, lambda text: text.replace(b'"F32"', f'"{dtype}"'.encode()))


def _with_number(start: int, value: float, data: bytes) -> bytes:
    at = 8 + _head_size(data) + start
    return data[:at] + struct.pack("<f", value) + data[at + 4 :]


# --- weights in a model zip ----------------------------------------------------------------------------

PICKLED = ("policy.pth", "policy.optimizer.pth", "pytorch_variables.pth")  # as Stable-Baselines3 names them


def state_tricks(data: bytes) -> Tricks:
    """Weights and optimisers of a model zip: by others, by each other, by pickles under the old names."""
    names = [name for name in unzipped(data) if name.endswith(".safetensors")]
    for name in names:
        lens = entry(name, "weights'")
        yield from lens.lifted(byte_tricks, data)
        yield from lens.lifted(safetensors_tricks, data)
        for other in names:
            if other != name:
                yield Trick("weights swapped", f"{name} is {other}", partial(_copied, other, name))
    for name in PICKLED:
        for kind, payload in payloads().items():
            yield Trick("pickle", f"and {name}, {kind}", partial(with_entry, name, payload))
            yield Trick("pickle", f"{name} alone, {kind}", partial(_pickles_alone, name, payload))


def _copied(source: str, target: str, data: bytes) -> bytes:
    return with_entry(target, unzipped(data)[source], data)


def _pickles_alone(name: str, payload: bytes, data: bytes) -> bytes:
    """The zip as an earlier version wrote it, but for one pickle."""
    entries = {key: value for key, value in unzipped(data).items() if not key.endswith(".safetensors")}
    return zipped({**entries, name: payload})
