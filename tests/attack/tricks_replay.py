"""Replays that lie: lines by others, in another order, without end; bombs of zstd."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import struct
from functools import partial
from typing import Any

import zstandard

from tests.attack.tricks import Lens, Trick, Tricks
from tests.attack.tricks_json import json_tricks

MANY = 150_000
CHANGES = {
    "no change": "[]",
    "the same piece hurt": '[["red.tank0", "blood", 1]]',
    "huge blood": '[["red.tank0", "blood", 1000000000]]',
    "blood is a text": '[["red.tank0", "blood", "x"]]',
    "off the map": '[["red.tank0", "cell", 6000]]',
    "a private field": '[["red.tank0", "__class__", 1]]',
    "nobody": '[["nobody", "cell", 1]]',
    "null": "[null]",
    "of four": "[[1, 2, 3, 4]]",
    "an object": "{}",
    "unhashable": '[[["a"], {"b": 1}, []]]',
    "the tick": '[["game", "tick", 32767]]',
}
ORDERS = {
    "no orders": "[]",
    "a number": "[1]",
    "a long path": json.dumps(["move tank0 " + " ".join(["0104"] * 500)]),
    "an unknown order": '["explode tank0"]',
    "an empty one": '[""]',
    "a text": '"x"',
    "half a character": '["\\ud800"]',
    "10,000 texts": json.dumps(["x"] * 10_000),
}


def lines_of(data: bytes) -> list[bytes]:
    """Lines of a replay's file."""
    return zstandard.ZstdDecompressor().decompressobj().decompress(data).splitlines()


def packed(text: bytes, **options: Any) -> bytes:
    """Text in zstd."""
    return zstandard.ZstdCompressor(level=3, **options).compress(text)


def of_lines(lines: list[bytes]) -> bytes:
    """A replay's file, with the hash that its end must have, if that can be said."""
    with contextlib.suppress(Exception):  # a line that is no JSON has no hash
        read = [json.loads(line) for line in lines]
        digest = hashlib.sha256()
        for line in read[:-1]:
            digest.update(json.dumps(line, separators=(",", ":"), ensure_ascii=False).encode() + b"\n")
        if read[-1].get("sha256"):
            lines = [*lines[:-1], json.dumps({**read[-1], "sha256": digest.hexdigest()}).encode()]
    return packed(b"".join(line + b"\n" for line in lines), write_checksum=True)


def replay_tricks(data: bytes) -> Tricks:
    """The first and last line of every type by others; lines that are none."""
    kinds = [json.loads(line)["type"] for line in lines_of(data)]
    for kind in dict.fromkeys(kinds):
        for number in dict.fromkeys((kinds.index(kind), len(kinds) - 1 - kinds[::-1].index(kind))):
            yield from _line_lens(number).lifted(json_tricks, data)
            for times in (0, 2, MANY):
                yield Trick(
                    "lines", f"line {number + 1} ({kind}) {times} times", partial(_repeated, number, times)
                )
    first = kinds.index("orders") if "orders" in kinds else 1
    for name, line in _evil_lines().items():
        for times in (1, MANY) if len(line) < 100 else (1, 100):
            yield Trick("lines", f"{times} times {name}", partial(_put_line, first, line, times))
    yield Trick("lines", "backwards", lambda d: of_lines(lines_of(d)[::-1]))
    yield Trick("lines", "an end of line too few", lambda d: packed(b"\n".join(lines_of(d))))


def _line_lens(number: int) -> Lens:
    def put(data: bytes, line: bytes) -> bytes:
        lines = lines_of(data)
        lines[number] = line.replace(b"\n", b" ")
        return of_lines(lines)

    return Lens(f"line {number + 1}", lambda data: lines_of(data)[number], put)


def _repeated(number: int, times: int, data: bytes) -> bytes:
    lines = lines_of(data)
    return of_lines([*lines[:number], *lines[number : number + 1] * times, *lines[number + 1 :]])


def _put_line(number: int, line: bytes, times: int, data: bytes) -> bytes:
    lines = lines_of(data)
    return of_lines([*lines[:number], *[line] * times, *lines[number:]])


def _evil_lines() -> dict[str, bytes]:
    lines = {
        f"edit, {name}": f'{{"type":"edit","tick":0,"changes":{text}}}' for name, text in CHANGES.items()
    }
    for name, text in ORDERS.items():
        lines[f"orders, {name}"] = f'{{"type":"orders","tick":0,"camp":"red","orders":{text}}}'
    for kind in ("orders", "edit", "event", "state", "view", "head", "end"):
        lines[f"a bare {kind}"] = f'{{"type":"{kind}"}}'
        lines[f"{kind} of a late tick"] = f'{{"type":"{kind}","tick":32000}}'
    return {name: line.encode() for name, line in lines.items()}


def zstd_tricks(data: bytes) -> Tricks:
    """Bombs, frames, windows."""
    text = b"\n".join(lines_of(data)) + b"\n"
    yield Trick("zstd", "60 MB of spaces", lambda _: packed(text + b" " * 60_000_000))
    yield Trick("zstd", "2 GB of zeros", lambda _: _zstd_bomb(2048))
    yield Trick("zstd", "60 MB in one line", lambda _: packed(_long_line() + text))
    yield Trick("zstd", "60 MB of line ends", lambda _: packed(text + b"\n" * 60_000_000))
    yield Trick("zstd", "1,000,000 empty objects", lambda _: packed(text + b"{}\n" * 1_000_000))
    yield Trick("zstd", "two frames", lambda d: d + d)
    yield Trick("zstd", "100,000 empty frames", lambda d: packed(b"") * 100_000 + d)
    yield Trick(
        "zstd", "a frame that is skipped", lambda d: b"\x50\x2a\x4d\x18" + struct.pack("<I", 2**31) + d
    )
    yield Trick("zstd", "a window of 2 GB", lambda d: d[:4] + b"\x00\xa8" + d[6:])
    yield Trick("zstd", "no checksum", lambda _: packed(text, write_checksum=False, write_content_size=False))
    yield Trick("zstd", "said 2^60 long", lambda d: d[:4] + b"\xe0" + struct.pack("<Q", 2**60) + d[6:])
    yield Trick("zstd", "nothing in it", lambda _: packed(b""))


def _long_line() -> bytes:
    return b'{"type": "head", "x": "' + b"x" * 60_000_000 + b'"}\n'


def _zstd_bomb(millions: int) -> bytes:
    file = io.BytesIO()
    with zstandard.ZstdCompressor().stream_writer(file, closefd=False) as writer:
        for _ in range(millions):
            writer.write(bytes(1 << 20))
    return file.getvalue()
