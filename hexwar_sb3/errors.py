"""Our errors. Each says where, what was found and what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

SHOWN_CHARACTERS = 300  # of a stranger's text, in a message


def shortened(text: str) -> str:
    """Text that may be a stranger's, fit for a terminal: cut, and without characters that steer it."""
    cut = text if len(text) <= SHOWN_CHARACTERS else text[:SHOWN_CHARACTERS] + "..."
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in cut)


class HexWarError(Exception):
    """Base of every error that a user of hexwar_sb3 can cause."""


class ConfigError(HexWarError, ValueError):
    """A setting is out of its range."""


class OrderError(HexWarError, ValueError):
    """An order that cannot even be read (an illegal but well-formed order is refused, not raised)."""


class UnknownNameError(HexWarError, KeyError):
    """A scenario, bot or piece that does not exist, with the nearest name that does."""

    says = "unknown {kind} {name!r}"

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        self.parts = kind, name, names
        name = shortened(name)
        spelt = {known_name.casefold(): known_name for known_name in names}
        close = difflib.get_close_matches(name.casefold(), spelt, n=1)
        hint = f"did you mean {spelt[close[0]]!r}?" if close else f"known: {', '.join(names)}"
        self.message = f"{self.says.format(kind=kind, name=name)}; {hint}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self.parts  # as it goes from process to process


class UnknownSettingError(UnknownNameError, TypeError):
    """A keyword that nobody takes; a TypeError with Python's own phrase, which wrappers of others look for."""

    says = "got an unexpected keyword argument {name!r}: unknown {kind}"

    def __init__(self, kind: str, name: str | None = None, known: Iterable[str] = ()) -> None:
        if name is None:  # `gymnasium.make` makes a TypeError anew, from its text and no more
            self.parts, self.message = (kind,), kind  # type: ignore[assignment]
            Exception.__init__(self, kind)
        else:
            super().__init__(kind, name, known)


class BusyError(HexWarError, RuntimeError):
    """A folder that another process is working in."""


class TrainingError(HexWarError, RuntimeError):
    """Training cannot go on: what was learned so far is kept."""


class ClusterError(HexWarError, RuntimeError):
    """A cluster that cannot be reached, a worker that is another program, or a job that failed there."""


class FileFormatError(HexWarError, ValueError):
    """A file that cannot be used: names the file, the place in it, what was found and expected."""

    def __init__(self, path: str | Path, place: str, *, found: str, expected: str) -> None:
        self.path, self.place, self.found, self.expected = (
            str(path),
            shortened(place),
            shortened(found),
            expected,
        )
        super().__init__(f"{shortened(self.path)}: {self.place}: found {self.found}; expected {expected}")

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
