"""JSON that lies: every value by every other, keys away, twice, unknown; encodings, depth, many keys."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from tests.attack.archives import sb3_pickle
from tests.attack.tricks import MOST_BYTES, Make, Trick, Tricks, instead

Place = tuple[str | int, ...]
HERE = "@here@"
VALUES = {
    **{text: text for text in ("null", "true", "false", "-1", "0", "1", "0.5", "1e308", "1e400", "NaN")},
    "-Infinity": "-Infinity",
    **{f"10^{n}": "1" + "0" * n for n in (9, 12, 39, 400, 5000)},
    **{f"2^{n}": str(2**n) for n in (31, 63, 64)},
    "-2^63": str(-(2**63)),
    "nothing": '""',
    "x": '"x"',
    "NUL": '"a\\u0000b"',
    "half a character": '"\\ud800"',
    "escape": '"\\u001b[2J\\u202e"',
    "a long text": json.dumps("x" * 100_000),
    "a path up": '"../../../etc/passwd"',
    "/dev/zero": '"/dev/zero"',
    "list": "[]",
    "object": "{}",
    "list of lists": "[[], {}, null]",
    "1,000 zeros": "[" + "0," * 999 + "0]",
    "200 levels": "[" * 200 + "]" * 200,
    "100,000 levels": "[" * 100_000,
    "an SB3 pickle": sb3_pickle(),
}
"""What stands in the place of every value."""


def json_tricks(data: bytes) -> Tricks:
    """All of it."""
    yield from whole_tricks(data)
    document = json.loads(data)
    for place in places(document):
        at = "/".join(map(str, place))
        for name, value in VALUES.items():
            yield Trick("json value", f"{at} = {name}", partial(with_value, place, value))
        yield Trick("json key", f"{at} away", partial(_without, place))
        if isinstance(place[-1], str):
            for name in ("null", "-1", "x"):
                yield Trick("json key", f"{at} twice, {name}", partial(_twice, place, VALUES[name]))
            yield Trick("json key", f"{at} twice, the same", partial(_twice, place, None))


def unhashed_tricks(data: bytes) -> Tricks:
    """The same of a document without its hashes, which would betray every change."""
    for trick in json_tricks(_no_hashes(data)):
        yield Trick(trick.family, f"no hash, {trick.name}", partial(_spoilt, trick.make))


def _spoilt(make: Make, data: bytes) -> bytes:
    return make(_no_hashes(data))


def _no_hashes(data: bytes) -> bytes:
    def no_hash(values: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in values.items() if key != "hash"}

    return json.dumps(json.loads(data, object_hook=no_hash)).encode()


def whole_tricks(_: bytes) -> Tricks:
    """What is done to a JSON text as a whole."""
    for name, value in VALUES.items():
        yield Trick("json whole", f"{name} alone", partial(instead, value.encode()))
    for code in ("utf-16", "utf-16-le", "utf-32", "utf-8-sig"):
        yield Trick("json whole", code, partial(_encoded, code))
    yield Trick("json whole", "latin-1", lambda d: d.replace(b'"', b'"\xe4', 1))
    yield Trick("json whole", "150,000 keys", lambda d: with_more(_many_keys(150_000), d))
    yield Trick("json whole", "150,000 keys, the last twice", lambda d: with_more(_many_keys(150_000, 1), d))
    yield Trick("json whole", "150,000 keys alone", lambda _: b"{" + _many_keys(150_000, 1) + b"}")
    for name in ("an SB3 pickle", "/dev/zero", "list"):
        more = f'"zz": {VALUES[name]}'.encode()
        yield Trick("json key", f"unknown key, {name}", partial(with_more, more))
    for key in ("__class__", "__init__", "predict", "learn", "policy", "_logger", "tensorboard_log", "type"):
        yield Trick("json key", f"unknown key {key}", partial(with_more, f'"{key}": "x"'.encode()))
    yield Trick("json whole", "4 MB of spaces", lambda d: d + b" " * (MOST_BYTES - len(d)))
    yield Trick("json whole", "4 MB of brackets", lambda _: b"[" * MOST_BYTES)


def places(value: Any, start: Place = ()) -> Iterator[Place]:
    """Places of a document: all keys, and of a list its first and last."""
    keys: Iterable[str | int] = ()
    if isinstance(value, dict):
        keys = value if len(value) <= 200 else [*itertools.islice(value, 3)]
    elif isinstance(value, list) and value:
        keys = dict.fromkeys((0, len(value) - 1))
    for key in keys:
        yield (*start, key)
        yield from places(value[key], (*start, key))


def with_value(place: Place, value: str, data: bytes) -> bytes:
    """Another value in a place, as it stands in a text."""
    document = json.loads(data)
    _parent(document, place)[place[-1]] = HERE
    return json.dumps(document).replace(f'"{HERE}"', value, 1).encode()


def with_more(more: bytes, data: bytes) -> bytes:
    """Keys and values before all others."""
    start, brace, rest = data.partition(b"{")
    return start + brace + more + (b"" if rest.strip() == b"}" else b", ") + rest


def _without(place: Place, data: bytes) -> bytes:
    document = json.loads(data)
    del _parent(document, place)[place[-1]]
    return json.dumps(document).encode()


def _twice(place: Place, value: str | None, data: bytes) -> bytes:
    """The key first with another value, then with its own: Python's last one counts."""
    document = json.loads(data)
    parent = _parent(document, place)
    rest, own = dict(parent), parent[place[-1]]
    parent.clear()
    parent |= {HERE: 0, **rest}
    text = json.dumps(place[-1]) + ": " + (json.dumps(own) if value is None else value)
    return json.dumps(document).replace(f'"{HERE}": 0', text, 1).encode()


def _parent(document: Any, place: Place) -> Any:
    for key in place[:-1]:
        document = document[key]
    return document


def _encoded(code: str, data: bytes) -> bytes:
    return data.decode().encode(code)


def _many_keys(count: int, same: int = 0) -> bytes:
    keys = [f'"k{k}": 0' for k in range(count)] + [f'"k{count - 1}": 0'] * same
    return ", ".join(keys).encode()
