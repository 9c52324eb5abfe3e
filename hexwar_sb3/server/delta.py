"""What is new in a document of JSON: made of the old one and the new one, and of nothing else (formats/play.md).

Where neither document has a thing that a camp does not know, what is new between them has none either.
"""

from __future__ import annotations

import json
from typing import Any, TypeAlias

SET, GROW, GONE = "=", "+", "-"
Change: TypeAlias = "dict[str, Change] | list[Any]"


def new_in(old: Any, new: Any) -> Change:
    """The change that makes the new value of the old one; of equal objects it is `{}`.

    Example:
        >>> new_in({"a": [1, 2], "b": 1}, {"a": [1, 2, 3], "c": [4]})
        {'a': ['+', 2, [3]], 'b': ['-'], 'c': ['=', [4]]}
    """
    if isinstance(old, dict) and isinstance(new, dict):
        return _new_names(old, new)
    if isinstance(old, list) and isinstance(new, list) and old:
        same = _same_entries(old, new)
        return [GROW, same, new[same:]] if same else [SET, new]
    return [SET, new]


def _new_names(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Change]:
    gone: dict[str, Change] = {name: [GONE] for name in old if name not in new}
    others = {name: new_in(old.get(name), new[name]) for name in new if not _equal(old, new, name)}
    return dict(sorted((gone | others).items()))


def _equal(old: dict[str, Any], new: dict[str, Any], name: str) -> bool:
    return name in old and same_json(old[name], new[name])


def _same_entries(old: list[Any], new: list[Any]) -> int:
    """How many entries both lists begin with."""
    pairs = enumerate(zip(old, new, strict=False))
    return next((n for n, pair in pairs if not same_json(*pair)), min(len(old), len(new)))


def same_json(one: Any, other: Any) -> bool:
    """Whether two values are the same in JSON, where 1, 1.0 and true differ."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same_json(one[name], other[name]) for name in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same_json, one, other))
    return type(one) is type(other) and bool(one == other)


def changed(value: Any, change: Change) -> Any:
    """The value with the change; the value itself is left as it was.

    Example:
        >>> changed({"a": [1, 2], "b": 1}, {"a": ["+", 2, [3]], "b": ["-"], "c": ["=", [4]]})
        {'a': [1, 2, 3], 'c': [4]}
    """
    if isinstance(change, list):
        return change[1] if change[0] == SET else [*value[: change[1]], *change[2]]
    new = dict(value)
    for name, one in change.items():
        if one == [GONE]:
            del new[name]
        else:
            new[name] = changed(new.get(name), one)
    return new


def frozen(document: Any) -> Any:
    """A copy in plain JSON, which does not change with the lists that the document was made of."""
    return json.loads(json.dumps(document))
