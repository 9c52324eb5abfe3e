"""Kinds of values that were read: the fields of a dataclass, by their annotations, before anything uses them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from hexwar_sb3.errors import FileFormatError

MOST_WHOLE = 2**63 - 1
_WORDS: dict[object, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a finite number",
    str: "a text",
    Path: "a path",
    NoneType: "null",
    dict: "names and values",
    list: "a list",
    tuple: "a list",
}


def read_fields(
    kind: type,
    values: object,
    source: str | Path,
    error: type[FileFormatError] = FileFormatError,
    place: str = "",
    *,
    whole: bool = False,
) -> dict[str, Any]:
    """Check JSON values by the annotations of a dataclass, and give them as it takes them: lists become tuples.

    Args:
        kind: the dataclass.
        values: by name.
        source: its name in messages.
        error: type of the error.
        place: of the values within the source.
        whole: every field must be there.

    Raises:
        FileFormatError: of the type `error`; a name is unknown or missing, or a value is of another kind.
    """
    hints = _hints(kind)
    if not isinstance(values, dict):
        raise error(source, place or "file", found=type(values).__name__, expected="names and values")
    for name in values:
        if name not in hints:
            where, known = f"{place}.{name}".strip("."), ", ".join(hints)
            raise error(source, where, found="an unknown setting", expected=f"one of {known}")
    for name in hints if whole else ():
        if name not in values:
            raise error(source, f"{place}.{name}".strip("."), found="nothing", expected=_say(hints[name]))
    for name, value in values.items():
        if not fits(value, hints[name]):
            where = f"{place}.{name}".strip(".")
            raise error(source, where, found=repr(value), expected=_say(hints[name]))
    return {name: _as(value, hints[name]) for name, value in values.items()}


def fits(value: object, hint: Any) -> bool:
    """Whether a JSON value is of a kind, as an annotation says it; a tuple may be a list."""
    origin, args = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin is Annotated:
        return fits(value, args[0])
    if origin in (Union, UnionType):
        return any(fits(value, one) for one in args)
    if origin is Literal:
        return any(type(value) is type(one) and value == one for one in args)
    if origin is tuple:
        return isinstance(value, list | tuple) and _each_fits(value, args)
    if origin in (dict, Mapping):
        return isinstance(value, dict) and all(fits(one, args[1]) for one in value.values())
    return _is_plain(value, hint)


def _each_fits(values: list[object] | tuple[object, ...], args: tuple[Any, ...]) -> bool:
    if args[-1] is Ellipsis:
        return all(fits(value, args[0]) for value in values)
    return len(values) == len(args) and all(map(fits, values, args))


def _is_plain(value: object, hint: type) -> bool:
    if hint is float and isinstance(value, float):
        return math.isfinite(value)
    if hint in (int, float):
        return type(value) is int and abs(value) <= MOST_WHOLE
    if hint is Path:
        return isinstance(value, str | Path) and "\0" not in str(value)
    return type(value) is hint


def _as(value: Any, hint: Any) -> Any:
    """A value that fits, as the dataclass takes it."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _as(value, args[0])
    if origin in (Union, UnionType):
        return _as(value, next(one for one in args if fits(value, one)))
    if origin is tuple:
        kinds = [args[0]] * len(value) if args[-1] is Ellipsis else args
        return tuple(map(_as, value, kinds))
    return Path(value) if hint is Path else value


def _say(hint: Any) -> str:
    """What a value may be, in words."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _say(args[0])
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(map(_say, args)))
    if origin is Literal:
        return " or ".join(map(repr, args))
    return _WORDS.get(origin or hint, str(hint))


@cache
def _hints(kind: type) -> dict[str, Any]:
    """Annotations of the fields, resolved."""
    found = get_type_hints(kind, include_extras=True)
    return {entry.name: found[entry.name] for entry in fields(kind)}
