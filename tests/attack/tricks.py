"""Ways to spoil files: a trick is a function from bytes to bytes, a case a change of a folder."""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.attack.archives import payloads, unzipped, with_entry

MOST_BYTES = 4 << 20  # of a bad file

Make = Callable[[bytes], bytes]


@dataclass(frozen=True)
class Trick:
    """One way to spoil some bytes."""

    family: str
    name: str
    make: Make


Tricks = Iterator[Trick]
Tricksters = Callable[[bytes], Tricks]


@dataclass(frozen=True)
class Case:
    """One way to spoil a folder that holds valid files."""

    family: str
    name: str
    change: Callable[[Path], object]


@dataclass(frozen=True)
class Lens:
    """Bytes within bytes: an entry of a zip, a line of a replay."""

    name: str
    get: Make
    put: Callable[[bytes, bytes], bytes]
    kind: str = ""  # begins the families of what is inside, if they are families of their own

    def lifted(self, tricks: Tricksters, whole: bytes) -> Tricks:
        """The tricks of what is inside, done to the whole."""
        for trick in tricks(self.get(whole)):
            family = f"{self.kind} {trick.family}".strip()
            yield Trick(family, f"{self.name}: {trick.name}", partial(self.within, trick.make))

    def within(self, make: Make, whole: bytes) -> bytes:
        """Spoil what is inside."""
        return self.put(whole, make(self.get(whole)))


def entry(name: str, kind: str = "") -> Lens:
    """Lens on an entry of a zip."""
    return Lens(
        name, lambda data: unzipped(data)[name], lambda data, inner: with_entry(name, inner, data), kind
    )


def instead(value: bytes, _: bytes = b"") -> bytes:
    """Something else altogether."""
    return value


# --- any bytes -----------------------------------------------------------------------------------------


def byte_tricks(data: bytes) -> Tricks:
    """Truncations, flips, insertions, pickles."""
    n = len(data)
    rng = random.Random(n)
    for end in sorted({0, 1, 2, 4, 8, n // 4, n // 2, n - n // 8, n - 64, n - 22, n - 8, n - 2, n - 1}):
        if 0 <= end < n:
            yield Trick("cut", f"the first {end} bytes", partial(_cut, end))
    for _ in range(30):
        at, bit = rng.randrange(max(n, 1)), rng.randrange(8)
        yield Trick("flip", f"bit {bit} of byte {at}", partial(flipped, at, bit))
    for what in (b"\0", b"\xff\xff", b"\xef\xbb\xbf", b"\n", b"{", b"A" * 1000):
        at = rng.randrange(max(n, 1))
        yield Trick("insert", f"{what[:4]!r} at {at}", partial(_inserted, at, what))
    yield Trick("insert", "1 MB of zeros behind", lambda d: d + bytes(1 << 20))
    yield Trick("insert", "itself behind", lambda d: d + d)
    yield Trick("flip", "all bytes 255", lambda d: b"\xff" * len(d))
    yield Trick("flip", "backwards", lambda d: d[::-1])
    yield Trick("flip", "one zero", partial(instead, b"\0"))
    yield Trick("flip", "4 MB of zeros", lambda _: bytes(MOST_BYTES))
    for name, payload in payloads().items():
        yield Trick("pickle", f"{name} instead", partial(instead, payload))


def _cut(end: int, data: bytes) -> bytes:
    return data[:end]


def flipped(at: int, bit: int, data: bytes) -> bytes:
    """One bit the other way."""
    if not data:
        return b"\1"
    return data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]


def _inserted(at: int, what: bytes, data: bytes) -> bytes:
    return data[:at] + what + data[at:]


# --- folders -------------------------------------------------------------------------------------------


def of_file(file: str, tricks: Tricksters, valid: Path) -> Iterator[Case]:
    """Tricks with a file of a folder, as changes of the folder."""
    for trick in tricks((valid / file).read_bytes()):
        yield Case(trick.family, f"{file}: {trick.name}", partial(rewrite, file, trick.make))


def rewrite(file: str, make: Make, folder: Path) -> None:
    """Spoil a file of a folder."""
    data = (folder / file).read_bytes()
    (folder / file).write_bytes(make(data))


def place_cases(file: str) -> Iterator[Case]:
    """Something else in the place of a file."""
    ways: dict[str, Callable[[Path], object]] = {
        "missing": lambda path: path,
        "empty": Path.touch,
        "a folder": Path.mkdir,
        "a pipe": os.mkfifo,
        "a link to itself": lambda path: path.symlink_to(path.name),
        "1 TB of holes": _sparse,
        "a link to a pipe": _link_to_pipe,
    }
    for target in ("/dev/zero", "/dev/full", "/dev/null", "/proc/self/mem", "/nowhere", "."):
        ways[f"a link to {target}"] = partial(_link, target)
    for name, make in ways.items():
        yield Case("place", f"{file}: {name}", partial(_put_there, file, make))


def _put_there(file: str, make: Callable[[Path], object], folder: Path) -> None:
    (folder / file).unlink()
    make(folder / file)


def _link(target: str, path: Path) -> None:
    path.symlink_to(target)


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 40)


def _link_to_pipe(path: Path) -> None:
    os.mkfifo(path.parent / "pipe")
    path.symlink_to("pipe")


def swapped(name: str, first: str, second: str) -> Case:
    """Two files of a folder in each other's place."""
    return Case("place", name, partial(_swap, first, second))


def _swap(first: str, second: str, folder: Path) -> None:
    one, other = (folder / first).read_bytes(), (folder / second).read_bytes()
    (folder / first).write_bytes(other)
    (folder / second).write_bytes(one)


def copied_over(name: str, source: Path, target: str) -> Case:
    """A file by another one of its kind, or of another."""
    return Case("place", name, lambda folder: shutil.copyfile(source, folder / target))


def dealt(cases: Sequence[Case], seed: int, most: int) -> list[int]:
    """Numbers of so many cases, drawn from all families alike."""
    rng, families = random.Random(f"{seed}, {len(cases)}"), dict[str, list[int]]()
    for number, case in enumerate(cases):
        families.setdefault(case.family, []).append(number)
    hands, found = list(families.values()), list[int]()
    rng.shuffle(hands)
    for hand in hands:
        rng.shuffle(hand)
    while len(found) < most and any(hands):
        found.extend(hand.pop() for hand in hands if hand)
    return sorted(found[:most])
