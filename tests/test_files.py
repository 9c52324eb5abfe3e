"""Small JSON files, of strangers too."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.files import write_json
from hexwar_sb3.reading import MAX_JSON_BYTES, read_json

BROKEN = {
    "broken off": (
        b'{"a": ',
        "one.json: text, line 1, column 7: found Expecting value.*; expected a page as JSON",
    ),
    "nested without end": (b"[" * 100_000, "one.json: text: found maximum recursion depth"),
    "no UTF-8": (b'{"a": "\xff"}', "one.json: text: found .*can't decode"),
    "a list": (b"[1]", "one.json: file: found list; expected a page"),
    "too large": (b" " * (MAX_JSON_BYTES + 1), "one.json: file size: found more than 4194304 bytes"),
}


def test_an_object_comes_back(tmp_path: Path) -> None:
    write_json(tmp_path / "one.json", {"a": [1, None, "ä"]})

    assert read_json(tmp_path / "one.json") == {"a": [1, None, "ä"]}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_answered_with_file_and_place(what: str, tmp_path: Path) -> None:
    content, message = BROKEN[what]
    path = tmp_path / "one.json"
    path.write_bytes(content)

    with pytest.raises(FileFormatError, match=message):
        read_json(path, "a page")


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"none\.json: file: found No such file"):
        read_json(tmp_path / "none.json")
    with pytest.raises(FileFormatError, match="file: found Is a directory"):
        read_json(tmp_path)
