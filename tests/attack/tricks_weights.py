"""Weights that are none: headers of safetensors that lie, tensors by others in what torch reads without unpickling."""

from __future__ import annotations

import io
import json
import math
import struct
from collections.abc import Callable
from functools import partial
from typing import Any

import torch

from tests.attack.archives import unzipped, with_entry
from tests.attack.tricks import Lens, Make, Trick, Tricks, byte_tricks, entry
from tests.attack.tricks_json import whole_tricks
from tests.attack.tricks_zip import zip_tricks

DTYPES = ("I32", "U32", "BF16", "F16", "F64", "C64", "I64", "BOOL", "U8", "X", "")


def safetensors_tricks(data: bytes) -> Tricks:
    """The header by others, and its arrays one by one."""
    size = _head_size(data)
    head = json.loads(data[8 : 8 + size])
    for length in (0, 1, size - 1, size + 1, 2**31, 2**40, 2**63, 2**64 - 1):
        yield Trick("weights header", f"said {length} long", partial(_said_long, length))
    names = [name for name in head if name != "__metadata__"]
    for name in (names[0], names[-1]):
        yield from _array_tricks(name, head[name])
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
    for value in (math.nan, math.inf, 1e38):
        yield Trick("weights value", f"{name} {value}", partial(_with_number, start, value))


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


# --- what torch wrote ----------------------------------------------------------------------------------

TENSORS: dict[str, Callable[[torch.Tensor], Any]] = {
    "NaN": lambda t: t * math.nan,
    "inf": lambda t: t + math.inf,
    "complex": lambda t: t.to(torch.complex64),
    "float64": lambda t: t.double(),
    "float16": lambda t: t.half(),
    "int64": lambda t: t.long(),
    "an axis more": lambda t: t[None],
    "empty": lambda t: t.reshape(-1)[:0],
    "twice": lambda t: torch.cat([t.reshape(-1)] * 2),
    "turned over": lambda t: t.T,
    "sparse": lambda t: t.to_sparse(),
    "without storage": lambda t: t.to("meta"),
    "10^10 numbers in one": lambda _: torch.zeros(1).expand(10**10),
    "a list": lambda t: t.tolist(),
    "a text": lambda _: "x",
    "nothing": lambda _: None,
}
STATES: dict[str, Callable[[dict[str, Any]], Any]] = {
    "with an unknown key": lambda s: {**s, "zz": 1},
    "without its first": lambda s: dict([*s.items()][1:]),
    "as a list": lambda s: [s],
    "as a tensor": lambda _: torch.zeros(3),
    "as a text": lambda _: "x",
    "empty": lambda _: {},
    "with a learning rate of NaN": lambda s: _each_group(s, "lr", math.nan),
    "with a learning rate of a text": lambda s: _each_group(s, "lr", "x"),
    "with betas of 2": lambda s: _each_group(s, "betas", (2.0, 2.0)),
    "with an epsilon of -1": lambda s: _each_group(s, "eps", -1.0),
    "with 100,000 groups": lambda s: {**s, "param_groups": s.get("param_groups", []) * 100_000},
    "in the old format": lambda s: s,
}


def state_tricks(data: bytes) -> Tricks:
    """Weights and optimiser of a model zip."""
    for name in unzipped(data):
        if name.endswith(".pth"):
            lens = entry(name, "tensors'")
            yield from lens.lifted(byte_tricks, data)
            yield from lens.lifted(zip_tricks, data)
            for kind in (*TENSORS, *STATES):
                yield Trick("tensors", f"{name} {kind}", partial(_with_state, name, kind))


def _each_group(state: dict[str, Any], name: str, value: Any) -> Any:
    return {**state, "param_groups": [{**group, name: value} for group in state.get("param_groups", [])]}


def _with_state(name: str, kind: str, data: bytes) -> bytes:
    """The first matrix of an entry spoilt, or its whole state."""
    state = torch.load(io.BytesIO(unzipped(data)[name]), weights_only=True)
    if kind in TENSORS:
        state = _first_spoilt(state, TENSORS[kind])
    elif isinstance(state, dict):
        state = STATES[kind](state)
    file = io.BytesIO()
    torch.save(state, file, _use_new_zipfile_serialization=kind != "in the old format")
    return with_entry(name, file.getvalue(), data)


def _first_spoilt(state: Any, make: Callable[[torch.Tensor], Any]) -> Any:
    if isinstance(state, torch.Tensor):
        return make(state)
    if isinstance(state, dict):
        for key, value in state.items():
            if isinstance(value, dict) or (isinstance(value, torch.Tensor) and value.ndim > 1):
                return {**state, key: _first_spoilt(value, make)}
    return state
