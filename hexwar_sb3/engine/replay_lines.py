"""What each line of a replay may hold: one table of keys and kinds, checked before anything follows a line.

A game that was recorded has few lines, so the limits are far above any: at most one line of orders a tick and camp,
MAX_LINES lines, and MAX_CHANGES changes by hand in all, each of which costs a look at the whole position.
Playing a game again costs what the game costs; nothing else about a file does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.record import STATE_TICKS, Line
from hexwar_sb3.engine.records import PATH_CELLS
from hexwar_sb3.engine.replay_file import MAX_LINES, fail
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.view import SideView
from hexwar_sb3.maps.document import shown
from hexwar_sb3.maps.geometry import DIRECTION_NAMES
from hexwar_sb3.maps.scenario import MAX_CONTROL_POINTS, MAX_GAME_TICKS, MAX_SIDE_PIECES
from hexwar_sb3.rules.enums import Camp

MAX_CHANGES = 2_000  # by hand, in all edits of a game; an edit counts once itself
STEPS_A_CHANGE = 5  # of a path by hand, which costs as much as a change
MAX_LOOKS = MAX_GAME_TICKS // STATE_TICKS + 2  # lines of states or views
MAX_TASKS = 64  # that a piece chooses from
MAX_CHARACTERS = 10_000  # of a text; an order of a whole path has 520
MOST = 2**31 - 1
REWARD = ("points", "own", "enemy")  # parts of a gain, points
CHOICE = ("piece", "chosen", "tasks", "values", "direction")
SINCE_2 = frozenset({"decision", "known"})  # kinds of lines that version 1 does not have
_CAMPS = tuple(map(camp_name, SIDES))
_OWNERS = tuple(map(camp_name, Camp))
_EVENTS = frozenset(event.name.lower() for event in Event)


class Kind(NamedTuple):
    """What a value must be: in words, and as a question to it."""

    says: str
    holds: Callable[[Any], bool]


def _is_text(value: Any) -> bool:
    return type(value) is str and len(value) <= MAX_CHARACTERS and value.isprintable()


def _is_whole(value: Any) -> bool:
    return type(value) is int and -MOST <= value <= MOST


def _is_list(value: Any, most: int, holds: Callable[[Any], bool]) -> bool:
    return isinstance(value, list | tuple) and len(value) <= most and all(map(holds, value))


def _of_camps(value: Any) -> bool:
    return isinstance(value, dict) and all(key in _CAMPS and _is_whole(one) for key, one in value.items())


def _is_refused(value: Any) -> bool:
    return _is_list(value, 2, _is_text) and len(value) == 2


def _is_piece(value: Any) -> bool:
    """[name, cell, blood, hidden, suppressed, carrier], as a state line has it."""
    if not isinstance(value, list | tuple) or len(value) != 6:
        return False
    name, cell, blood, hidden, suppressed, carrier = value
    texts = _is_text(name) and all(one is None or _is_text(one) for one in (cell, carrier))
    return texts and all(map(_is_whole, (blood, hidden, suppressed)))


def _is_known_piece(value: Any) -> bool:
    """[name, cell, blood, hidden, suppressed, carrier, seen]; what is not known is null."""
    if not isinstance(value, list | tuple) or len(value) != 7:
        return False
    name, cell, blood, hidden, suppressed, carrier, seen = value
    texts = _is_text(name) and all(one is None or _is_text(one) for one in (cell, carrier))
    return (
        texts
        and _is_whole(seen)
        and all(one is None or _is_whole(one) for one in (blood, hidden, suppressed))
    )


def _is_task(value: Any) -> bool:
    """A word, and a cell or a piece where it has one."""
    return _is_text(value) and 0 < len(value.split(" ")) <= 2 and all(value.split(" "))


def _is_choice(value: Any) -> bool:
    """[piece, number of the chosen task, tasks, values, direction], as a decision has it."""
    if not isinstance(value, list | tuple) or len(value) != len(CHOICE):
        return False
    piece, chosen, tasks, values, direction = value
    return (
        _is_text(piece)
        and _is_list(tasks, MAX_TASKS, _is_task)
        and type(chosen) is int
        and 0 <= chosen < len(tasks)
        and _is_list(values, MAX_TASKS, _is_whole)
        and len(values) in (0, len(tasks))
        and direction in ("", *DIRECTION_NAMES)
    )


def _is_change(value: Any) -> bool:
    """[who, field, value], as an edit has it."""
    return (
        isinstance(value, list | tuple)
        and len(value) == 3
        and _is_text(value[0])
        and _is_text(value[1])
        and _is_new_value(value[2])
    )


def _is_new_value(value: Any) -> bool:
    if isinstance(value, dict):
        return len(value) <= PATH_CELLS and all(map(_is_text, value)) and all(map(_is_whole, value.values()))
    if isinstance(value, list | tuple):
        return _is_list(value, PATH_CELLS, _is_text)
    if isinstance(value, float):
        return math.isfinite(value)
    return value is None or isinstance(value, bool) or _is_whole(value) or _is_text(value)


TYPE = Kind("the kind of the line", lambda value: type(value) is str)
TICK = Kind(
    f"a whole number from 0 to {MAX_GAME_TICKS}",
    lambda value: type(value) is int and 0 <= value <= MAX_GAME_TICKS,
)
WHOLE = Kind("a whole number", _is_whole)
FLAG = Kind("true or false", lambda value: type(value) is bool)
TEXT = Kind(f"a text of at most {MAX_CHARACTERS} printable characters", _is_text)
CAMP = Kind(" or ".join(_CAMPS), lambda value: type(value) is str and value in _CAMPS)
OF_CAMPS = Kind("a whole number for red or blue, or for both", _of_camps)
OF_BOTH = Kind("a whole number for red and for blue", lambda value: _of_camps(value) and len(value) == 2)
PLAIN = Kind(
    "a list of texts, or of names and values",
    lambda value: _is_list(value, 2 * MAX_SIDE_PIECES, lambda one: isinstance(one, str | dict)),
)


OWNERS = Kind(
    f"at most {MAX_CONTROL_POINTS} of {', '.join(_OWNERS)}",
    lambda value: _is_list(value, MAX_CONTROL_POINTS, _OWNERS.__contains__),
)
NAMES = Kind("a list of names of cells", lambda value: _is_list(value, 2 * MAX_SIDE_PIECES, _is_text))


def _of(annotation: object) -> Kind:
    """The kind of a field of an event or a view."""
    if get_origin(annotation) is tuple:
        return PLAIN
    kinds = get_args(annotation) or (annotation,)
    return FLAG if bool in kinds else WHOLE if int in kinds else TEXT


def _fields(kind: type) -> dict[str, Kind]:
    hints = get_type_hints(kind)
    return {entry.name: _of(hints[entry.name]) for entry in fields(kind) if entry.compare}


LINES: Mapping[str, tuple[Mapping[str, Kind], Mapping[str, Kind]]] = {
    "orders": (
        {
            "tick": TICK,
            "camp": CAMP,
            "orders": Kind(
                f"at most {MAX_SIDE_PIECES} orders as texts",
                lambda value: _is_list(value, MAX_SIDE_PIECES, _is_text),
            ),
        },
        {
            "refused": Kind(
                f"at most {MAX_SIDE_PIECES} orders, each with its reason",
                lambda value: _is_list(value, MAX_SIDE_PIECES, _is_refused),
            )
        },
    ),
    "edit": (
        {
            "tick": TICK,
            "changes": Kind(
                f"at most {MAX_CHANGES} changes [who, field, value]",
                lambda value: _is_list(value, MAX_CHANGES, _is_change),
            ),
        },
        {},
    ),
    "event": (
        {
            "tick": TICK,
            "kind": Kind("the kind of an event", lambda value: type(value) is str and value in _EVENTS),
            "piece": TEXT,
        },
        _fields(GameEvent),
    ),
    "state": (
        {
            "tick": TICK,
            "hash": TEXT,
            "margin": OF_BOTH,
            "owners": OWNERS,
            "pieces": Kind(
                "[name, cell, blood, hidden, suppressed, carrier] of each piece",
                lambda value: _is_list(value, 2 * MAX_SIDE_PIECES, _is_piece),
            ),
        },
        {},
    ),
    "view": ({**_fields(SideView), "tick": TICK, "camp": CAMP}, {}),
    "decision": (
        {
            "tick": TICK,
            "camp": CAMP,
            "choices": Kind(
                f"at most {MAX_SIDE_PIECES} of [{', '.join(CHOICE)}]",
                lambda value: _is_list(value, MAX_SIDE_PIECES, _is_choice),
            ),
        },
        {
            "reward": Kind(
                f"whole numbers for {', '.join(REWARD)}",
                lambda value: (
                    isinstance(value, dict)
                    and set(value) == set(REWARD)
                    and all(map(_is_whole, value.values()))
                ),
            )
        },
    ),
    "known": (
        {
            "tick": TICK,
            "pieces": Kind(
                "[name, cell, blood, hidden, suppressed, carrier, seen] of pieces",
                lambda value: _is_list(value, 2 * MAX_SIDE_PIECES, _is_known_piece),
            ),
        },
        {"owners": OWNERS, "known_margin": WHOLE, "bursting": NAMES, "fights": NAMES},
    ),
    "end": (
        {"tick": TICK, "over": FLAG, "own": OF_CAMPS},
        {
            "margin": OF_CAMPS,
            "winner": Kind(
                "red, blue, draw or null",
                lambda value: value is None or (type(value) is str and value in (*_CAMPS, "draw")),
            ),
            "sha256": TEXT,
        },
    ),
}
"""Keys that a line of a kind must have, and those that it may have; the head is a document of its own."""
_ALLOWED = {name: {"type": TYPE, **optional, **required} for name, (required, optional) in LINES.items()}


def checked(lines: Iterable[Any], source: Path) -> tuple[Line, ...]:
    """Check lines as they come: kinds, all values of those after the head, and that they are as few as a game's.

    Raises:
        ReplayFileError: one is of another kind or holds another value, time runs backwards, or there are too many.
    """
    found, limits = list[Line](), _Limits(source)
    for number, line in enumerate(lines, start=1):
        kind = line.get("type") if isinstance(line, dict) else line
        place = f"line {number}"
        if number > MAX_LINES:
            fail(source, "file", "more lines", f"at most {MAX_LINES}")
        if number == 1:
            if kind != "head":
                fail(source, place, shown(kind), 'a line of type "head"')
        elif not isinstance(kind, str) or kind not in LINES or found[-1]["type"] == "end":
            fail(source, place, shown(kind), f"one of {', '.join(LINES)}, the last of them once")
        else:
            _check_line(line, source, place)
            limits.take(line, f"{place}, {kind}")
        found.append(line)
    if not found or found[-1]["type"] != "end":
        last = shown(found[-1]["type"]) if found else "nothing"
        fail(source, f"line {len(found)}", last, '"end" last: the file was cut short')
    return tuple(found)


def _check_line(line: Line, source: Path, place: str) -> None:
    allowed, required = _ALLOWED[line["type"]], LINES[line["type"]][0]
    for key, value in line.items():
        kind = allowed.get(key)
        if kind is None:
            fail(source, place, f"the key {shown(key)}", f"only the keys {', '.join(allowed)}")
        if not kind.holds(value):
            fail(source, f"{place}, {line['type']}.{key}", shown(value), kind.says)
    for key in required:
        if key not in line:
            fail(source, place, f"no {key!r}", f"the keys {', '.join(required)}")


def _cost(change: Sequence[Any]) -> int:
    """A change by hand counts once, a path by its length."""
    return 1 + (len(change[2]) // STEPS_A_CHANGE if isinstance(change[2], list | tuple) else 0)


class _Limits:
    """Time runs forwards; a camp's orders for a tick are one line; states, views and changes by hand are few."""

    def __init__(self, source: Path) -> None:
        self.source = source
        self.tick = self.changes = self.looks = 0
        self.given: set[str] = set()  # camps that gave orders for this tick

    def take(self, line: Line, place: str) -> None:
        """Look at one more line."""
        if line["tick"] < self.tick:
            fail(self.source, f"{place}.tick", str(line["tick"]), f"a whole number of at least {self.tick}")
        if line["tick"] > self.tick:
            self.given.clear()
        self.tick = line["tick"]
        if line["type"] == "orders":
            if line["camp"] in self.given:
                fail(self.source, place, f"orders of {line['camp']} twice", "one such line a tick and camp")
            self.given.add(line["camp"])
        self.changes += 1 + sum(map(_cost, line["changes"])) if line["type"] == "edit" else 0
        self.looks += line["type"] in ("state", "view")
        if self.changes > MAX_CHANGES:
            fail(self.source, place, "more changes by hand", f"at most {MAX_CHANGES} in a game")
        if self.looks > MAX_LOOKS:
            fail(self.source, place, f"more lines of type {line['type']}", f"at most {MAX_LOOKS} in a game")
