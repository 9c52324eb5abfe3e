from __future__ import annotations

import errno
from pathlib import Path

import pytest

from hexwar_sb3.files import replacing


def test_a_file_is_replaced_when_its_successor_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    path.write_text("old", encoding="utf-8")

    with replacing(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"

    assert path.read_text(encoding="utf-8") == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_while_writing_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    path.write_text("old", encoding="utf-8")

    with pytest.raises(IsADirectoryError), replacing(path) as temporary:
        (temporary.parent).write_text("ne", encoding="utf-8")

    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_named_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    path.write_text("old", encoding="utf-8")

    with (
        pytest.raises(OSError, match="no space left; the file is as it was before") as raised,
        replacing(path),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")

    assert raised.value.filename == str(path)
    assert path.read_text(encoding="utf-8") == "old"
