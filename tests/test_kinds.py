"""Kinds of values by annotations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pytest

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.kinds import read_fields


@dataclass(frozen=True, kw_only=True)
class Example:
    count: int = 1
    share: float = 0.5
    name: str = "x"
    yes: bool = True
    side: Literal["red", "blue"] = "red"
    maybe: int | None = None
    names: tuple[str, ...] = ()
    pair: tuple[int, float] = (1, 1.0)
    place: Path | None = None
    more: dict[str, float] | None = None


GOOD: dict[str, tuple[Any, Any]] = {
    "count": (3, 3),
    "share": (1, 1),
    "side": ("blue", "blue"),
    "maybe": (None, None),
    "names": (["a", "b"], ("a", "b")),
    "pair": ([1, 0.5], (1, 0.5)),
    "place": ("runs/x", Path("runs/x")),
    "more": ({"a": 1.5}, {"a": 1.5}),
}
WRONG: dict[str, list[Any]] = {
    "count": [True, 1.0, "1", None, [], 10**39],
    "share": [True, "x", float("nan"), float("inf"), 10**400, None],
    "name": [1, None, []],
    "yes": [1, "true", None],
    "side": ["green", 1, None, []],
    "maybe": [1.5, True, "x"],
    "names": ["ab", [1], {}, None],
    "pair": [[1], [1, 2, 3], [1.5, 1], "ab"],
    "place": [1, "a\0b", []],
    "more": [{"a": "b"}, [], {"a": None}],
}


@pytest.mark.parametrize("name", GOOD)
def test_a_value_of_its_kind_is_taken_as_the_class_takes_it(name: str) -> None:
    value, taken = GOOD[name]
    assert read_fields(Example, {name: value}, "file") == {name: taken}


@pytest.mark.parametrize("name", WRONG)
def test_a_value_of_another_kind_is_refused_with_its_place(name: str) -> None:
    for value in WRONG[name]:
        with pytest.raises(FileFormatError, match=rf"file: part\.{name}: found"):
            read_fields(Example, {name: value}, "file", place="part")


def test_names_that_are_unknown_or_missing_are_refused() -> None:
    with pytest.raises(FileFormatError, match="colour: found an unknown setting; expected one of count"):
        read_fields(Example, {"colour": 1}, "file")
    with pytest.raises(FileFormatError, match="count: found nothing; expected a whole number"):
        read_fields(Example, {}, "file", whole=True)
    with pytest.raises(FileFormatError, match="found list; expected names and values"):
        read_fields(Example, [], "file")
