"""A game under way, on disk: `*.partial.hwr`, its seed and the person's orders, line by line as they are accepted.

Each line is on the disk before anything that follows from it is told. A kill can tear the last line only, and what a
torn line says was told to nobody. Head and lines make the same game again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from hexwar_sb3.errors import BusyError, ConfigError, ReplayFileError
from hexwar_sb3.files import held
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.document import shown
from hexwar_sb3.reading import parse_json, read_bytes
from hexwar_sb3.server.person import EXPECTED, is_name

FORMAT = "hexwar-partial"
FORMAT_VERSION = 1
MOST_BYTES = 1 << 26  # a game has some hundred thousand


@dataclass(frozen=True, kw_only=True)
class Head:
    """All that a game is made of, but the orders."""

    scenario: Any  # a scenario's document, with its map
    rules: str  # their hash
    seed: int
    camp: Literal["red", "blue"]  # the person's
    player: str  # what the person is called
    opponent: str  # as it was given
    opponent_hash: str | None  # of its weights, or of what all bots do
    hints: str | None  # policy that gives hints, as it was given


@dataclass(frozen=True, kw_only=True)
class OrdersLine:
    """Orders that were given in a tick, and what the pieces were still to do after them."""

    tick: int
    orders: tuple[str, ...]
    plans: Any


@dataclass(frozen=True, kw_only=True)
class ClockLine:
    """The clock came so far, or plans were changed there."""

    tick: int
    plans: Any


@dataclass(frozen=True, kw_only=True)
class HintLine:
    """A hint was given."""

    tick: int
    piece: str


Line: TypeAlias = OrdersLine | ClockLine | HintLine
_LINES: dict[str, type[Line]] = {"orders": OrdersLine, "clock": ClockLine, "hint": HintLine}
_TYPES = {kind: name for name, kind in _LINES.items()}


class Partial:
    """The file of a game under way, held by one process at a time.

    Raises:
        BusyError: another process has it.
    """

    def __init__(self, path: Path, flags: int) -> None:
        self.path = path
        self._handle = os.open(path, flags | os.O_RDWR | getattr(os, "O_BINARY", 0), 0o666)
        if not held(self._handle):
            os.close(self._handle)
            raise BusyError(f"{path} is being played by another process; expected one at a time")

    @classmethod
    def begin(cls, path: Path, head: Head) -> Partial:
        """A new file.

        Raises:
            ConfigError: there is one already.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            partial = cls(path, os.O_CREAT | os.O_EXCL)
        except FileExistsError as error:
            raise ConfigError(
                f"{path} is there already; go on with --resume, or name another game"
            ) from error
        partial._append({"type": "head", "format": FORMAT, "version": FORMAT_VERSION} | asdict(head))
        return partial

    @classmethod
    def go_on(cls, path: Path) -> tuple[Partial, Head, list[Line]]:
        """A file that is there, to be written on; a last line that was torn is cut off.

        Raises:
            ReplayFileError: it is none; says where, what was found and what was expected.
        """
        data = read_bytes(path, MOST_BYTES, ReplayFileError)
        whole = data[: data.rfind(b"\n") + 1]
        head, *lines = [_parsed(line, n, path) for n, line in enumerate(whole.splitlines(), start=1)] or [{}]
        found = _head(head, path), [_line(line, n, path) for n, line in enumerate(lines, start=2)]
        partial = cls(path, 0)
        os.ftruncate(partial._handle, len(whole))
        return partial, *found

    def write(self, line: Line) -> None:
        """Append a line; it is on the disk when this returns."""
        self._append({"type": _TYPES[type(line)]} | asdict(line))

    def _append(self, values: Mapping[str, Any]) -> None:
        data = json.dumps(values, separators=(",", ":"), ensure_ascii=False).encode() + b"\n"
        size = os.lseek(self._handle, 0, os.SEEK_END)
        try:
            while data:
                data = data[os.write(self._handle, data) :]
            os.fsync(self._handle)
        except OSError:  # a full disk: half a line would spoil those that follow
            os.ftruncate(self._handle, size)
            raise

    def close(self) -> None:
        """Let others have it."""
        if self._handle >= 0:
            os.close(self._handle)
        self._handle = -1

    def remove(self) -> None:
        """The game is over and written as a whole."""
        self.close()
        self.path.unlink(missing_ok=True)


def _parsed(data: bytes, number: int, path: Path) -> dict[str, Any]:
    value = parse_json(data, path, "an object", ReplayFileError, f"line {number}")
    if not isinstance(value, dict):
        raise ReplayFileError(path, f"line {number}", found=shown(value), expected="an object")
    return value


def _head(values: dict[str, Any], path: Path) -> Head:
    for name, value in (("type", "head"), ("format", FORMAT), ("version", FORMAT_VERSION)):
        if values.get(name) != value:
            raise ReplayFileError(path, f"head.{name}", found=shown(values.get(name)), expected=shown(value))
    rest = {name: value for name, value in values.items() if name not in ("type", "format", "version")}
    head = Head(**read_fields(Head, rest, path, ReplayFileError, "head", whole=True))
    if not is_name(head.player):
        raise ReplayFileError(path, "head.player", found=ascii(head.player)[:80], expected=EXPECTED)
    return head


def _line(values: dict[str, Any], number: int, path: Path) -> Line:
    place, kind = f"line {number}", values.get("type")
    if not isinstance(kind, str) or kind not in _LINES:
        raise ReplayFileError(
            path, f"{place}.type", found=shown(kind), expected=f"one of {', '.join(_LINES)}"
        )
    rest = {name: value for name, value in values.items() if name != "type"}
    line = _LINES[kind](**read_fields(_LINES[kind], rest, path, ReplayFileError, place, whole=True))
    if isinstance(line, OrdersLine | ClockLine):
        _check_plans(line.plans, place, path)
    return line


def _check_plans(plans: object, place: str, path: Path) -> None:
    """Plans are texts by piece."""
    texts: Sequence[object] = [*plans.values()] if isinstance(plans, dict) else [None]
    for steps in texts:
        if not (isinstance(steps, list) and steps and all(isinstance(step, str) for step in steps)):
            raise ReplayFileError(path, f"{place}.plans", found=shown(plans), expected="steps by piece")
