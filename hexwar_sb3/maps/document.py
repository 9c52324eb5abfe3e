"""Reading JSON from strangers: every value is checked, and an error names its place."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NoReturn

from hexwar_sb3.errors import ConfigError, FileFormatError, shortened
from hexwar_sb3.maps.geometry import parse_cell
from hexwar_sb3.reading import parse_json, read_bytes
from hexwar_sb3.rules.indices import CellIndex

MAX_FILE_BYTES = 2_000_000
_SHOWN_CHARACTERS = 60  # of a wrong value, in a message


class Document:
    """A JSON object with its file and its place in it, for messages."""

    def __init__(self, data: object, source: str, error: type[FileFormatError], place: str = "file") -> None:
        self.source, self.error, self.place = source, error, place
        if not isinstance(data, dict):
            self.fail(place, shown(data), "an object { ... }")
        self.data: dict[str, Any] = data

    @classmethod
    def read(cls, path: Path, error: type[FileFormatError], expected: str = "a readable file") -> Document:
        """The object in a JSON file.

        Args:
            path: of the file.
            error: type of the error.
            expected: in place of a file that is missing, in words.

        Raises:
            FileFormatError: of the type `error`; no such file, too large, or not JSON.
        """
        content = read_bytes(path, MAX_FILE_BYTES, error, expected)
        return cls(parse_json(content, path, "an object", error, "file"), str(path), error)

    def fail(self, place: str, found: str, expected: str) -> NoReturn:
        """Refuse this document."""
        raise self.error(self.source, place, found=found, expected=expected)

    def has(self, *required: str) -> None:
        """Refuse missing keys."""
        for key in required:
            if key not in self.data:
                self.fail(self.place, f"no {key!r}", f"the keys {', '.join(required)}")

    def only(self, required: Collection[str], optional: Collection[str] = ()) -> None:
        """Refuse missing and unknown keys."""
        self.has(*required)
        for key in self.data:
            if key not in required and key not in optional:
                known = ", ".join((*required, *optional))
                self.fail(self.place, f"the key {shown(key)}", f"only the keys {known}")

    def at(self, key: str) -> str:
        """Place of a key, for messages."""
        return key if self.place == "file" else f"{self.place}.{key}"

    def text(self, key: str, limit: int = 80) -> str:
        """A string of 1 to `limit` printable characters."""
        value = self.data[key]
        if not (isinstance(value, str) and 0 < len(value) <= limit and value.isprintable()):
            self.fail(self.at(key), shown(value), f"a text of 1 to {limit} characters")
        return value

    def choice(self, key: str, choices: Collection[str]) -> str:
        """One of some words."""
        value = self.data[key]
        if not (isinstance(value, str) and value in choices):
            self.fail(self.at(key), shown(value), f"one of {', '.join(choices)}")
        return value

    def integer(self, key: str, low: int, high: int) -> int:
        """A whole number from `low` to `high`."""
        value = self.data[key]
        if type(value) is not int or not low <= value <= high:
            self.fail(self.at(key), shown(value), f"a whole number from {low} to {high}")
        return value

    def cell(self, key: str, name: str, width: int, height: int) -> CellIndex:
        """The cell of that name."""
        try:
            return parse_cell(name, width, height)
        except ConfigError as problem:
            self.fail(self.at(key), shown(name), f"a cell of the map; {shortened(str(problem))}")

    def flag(self, key: str) -> bool:
        """True or false; false if absent."""
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            self.fail(self.at(key), shown(value), "true or false")
        return value

    def texts(self, key: str, count: range) -> list[str]:
        """A list of strings, as many as `count` allows."""
        values = self._list(key, count)
        for i, value in enumerate(values):
            if not isinstance(value, str):
                self.fail(f"{self.at(key)}[{i}]", shown(value), "a text")
        return values

    def objects(self, key: str, count: range) -> Iterator[Document]:
        """A list of objects, as many as `count` allows."""
        for i, value in enumerate(self._list(key, count)):
            yield Document(value, self.source, self.error, f"{self.at(key)}[{i}]")

    def _list(self, key: str, count: range) -> list[Any]:
        value = self.data[key]
        if not isinstance(value, list):
            self.fail(self.at(key), shown(value), "a list")
        if len(value) not in count:
            least, most = count[0], count[-1]
            expected = str(least) if least == most else f"{least} to {most}"
            self.fail(self.at(key), f"{len(value)} entries", expected)
        return value


def shown(value: object) -> str:
    """A value as JSON, cut to a readable length."""
    text = json.dumps(value, ensure_ascii=False, default=repr)
    return text if len(text) <= _SHOWN_CHARACTERS else text[:_SHOWN_CHARACTERS] + "..."
