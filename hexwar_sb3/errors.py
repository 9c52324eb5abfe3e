"""Our errors. Each says where, what was found and what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any


class HexWarError(Exception):
    """Base of every error that a user of hexwar_sb3 can cause."""


class ConfigError(HexWarError, ValueError):
    """A setting is out of its range."""


class OrderError(HexWarError, ValueError):
    """An order that cannot even be read (an illegal but well-formed order is refused, not raised)."""


class UnknownNameError(HexWarError, KeyError):
    """A scenario, bot or piece that does not exist, with the nearest name that does."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        self.parts = kind, name, names
        spelt = {known_name.casefold(): known_name for known_name in names}
        close = difflib.get_close_matches(name.casefold(), spelt, n=1)
        hint = f"did you mean {spelt[close[0]]!r}?" if close else f"known: {', '.join(names)}"
        self.message = f"unknown {kind} {name!r}; {hint}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self.parts  # as it goes from process to process


class TrainingError(HexWarError, RuntimeError):
    """Training cannot go on: what was learned so far is kept."""


class FileFormatError(HexWarError, ValueError):
    """A file that cannot be used: names the file, the place in it, what was found and expected."""

    def __init__(self, path: str | Path, place: str, *, found: str, expected: str) -> None:
        self.path, self.place, self.found, self.expected = str(path), place, found, expected
        super().__init__(f"{path}: {place}: found {found}; expected {expected}")

    def __reduce__(self) -> tuple[Callable[[], FileFormatError], tuple[()]]:
        again = partial(type(self), self.path, self.place, found=self.found, expected=self.expected)
        return again, ()  # as it goes from process to process


class MapFileError(FileFormatError):
    """A broken map file."""


class ScenarioFileError(FileFormatError):
    """A broken scenario file."""


class ReplayFileError(FileFormatError):
    """A broken, truncated or foreign replay file."""


class PolicyFileError(FileFormatError):
    """A `policy/` folder that cannot be loaded."""


class CheckpointError(FileFormatError):
    """A checkpoint that cannot be resumed here."""
