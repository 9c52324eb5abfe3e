"""What a page may ask: one class a question, checked by its annotations before anything uses it (formats/play.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.document import shown
from hexwar_sb3.reading import parse_json

SOURCE = "message"  # its name in errors
VERSION = 1  # of the protocol
MOST_BYTES = 16_384  # of a message
MOST_SPEED = 64  # ticks a second
MOST_ID = 2**53 - 1  # whole numbers of a browser
Json = dict[str, Any]


@dataclass(frozen=True)
class Look:
    """What can the piece do, here or in another cell?"""

    piece: str
    at: int | None


@dataclass(frozen=True)
class Path:
    """Which way would it take?"""

    piece: str
    to: int
    from_: int | None


@dataclass(frozen=True)
class PlanFor:
    """Let it do this."""

    piece: str
    steps: tuple[str, ...]
    then: bool


@dataclass(frozen=True)
class Undo:
    """Take back the last plan."""


@dataclass(frozen=True)
class Cancel:
    """Forget what was planned for it."""

    piece: str


@dataclass(frozen=True)
class Run:
    """Let the clock run."""

    speed: int

    def __post_init__(self) -> None:
        if not 1 <= self.speed <= MOST_SPEED:
            raise _wrong("speed", str(self.speed), f"1..{MOST_SPEED} ticks a second")


@dataclass(frozen=True)
class Pause:
    """Stop it."""


@dataclass(frozen=True)
class StepTo:
    """Let it run for a moment."""

    to: Literal["tick", "event", "decision"]


@dataclass(frozen=True)
class SetStops:
    """What stops it by itself."""

    first_sight: bool
    own_loss: bool
    idle: bool


@dataclass(frozen=True)
class Hint:
    """What would the policy do?"""

    piece: str


@dataclass(frozen=True)
class Finish:
    """Play on to the end."""


Question: TypeAlias = (
    Look | Path | PlanFor | Undo | Cancel | Run | Pause | StepTo | SetStops | Hint | Finish
)  # fmt: skip
QUESTIONS: dict[str, type[Question]] = {
    "look": Look,
    "path": Path,
    "plan": PlanFor,
    "undo": Undo,
    "cancel": Cancel,
    "run": Run,
    "pause": Pause,
    "step": StepTo,
    "stops": SetStops,
    "hint": Hint,
    "finish": Finish,
}
ONLY_LOOKS = (Look, Path)  # what one who reads along may ask
_WORDS = {"from": "from_"}  # a word of Python's


def read_message(text: str | bytes) -> Json:
    """A message as an object.

    Raises:
        FileFormatError: it is none.
    """
    values = parse_json(text, SOURCE, "an object")
    if not isinstance(values, dict):
        raise _wrong("text", type(values).__name__, "an object")
    return values


def number_of(message: Json) -> int | None:
    """The `id` of a message; None where it has none."""
    number = message.get("id")
    return number if type(number) is int and abs(number) <= MOST_ID else None


def read_question(message: Json) -> Question:
    """The question in a message.

    Raises:
        FileFormatError: it is none; says where, what was found and what was expected.
    """
    if number_of(message) is None:
        raise _wrong("id", shown(message.get("id")), "a whole number")
    ask = message.get("ask")
    if not isinstance(ask, str) or ask not in QUESTIONS:
        raise _wrong("ask", shown(ask), f"one of {', '.join(QUESTIONS)}")
    fields = {_WORDS.get(name, name): value for name, value in message.items() if name not in ("id", "ask")}
    return QUESTIONS[ask](**read_fields(QUESTIONS[ask], fields, SOURCE, place=ask, whole=True))


def _wrong(place: str, found: str, expected: str) -> FileFormatError:
    return FileFormatError(SOURCE, place, found=found, expected=expected)
