from __future__ import annotations

import errno
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hexwar_sb3.errors import BusyError
from hexwar_sb3.files import replacing, write_json
from hexwar_sb3.folders import holding


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


WRITER = """
import os, signal, sys
from pathlib import Path
from hexwar_sb3.errors import BusyError
from hexwar_sb3.files import replacing, write_json
from hexwar_sb3.folders import holding
with replacing(Path(sys.argv[1])) as temporary:
    temporary.write_text("half", encoding="utf-8")
    os.kill(os.getpid(), signal.SIGKILL)
"""
HOLDER = """
import sys
from pathlib import Path
from hexwar_sb3.folders import holding
with holding(Path(sys.argv[1]), "run"):
    print("held", flush=True)
    sys.stdin.read()
"""


def _left_by_a_killed_writer(path: Path) -> list[Path]:
    subprocess.run([sys.executable, "-c", WRITER, str(path)], check=False)
    return list(path.parent.glob(".new-*"))


def test_the_next_writer_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    assert _left_by_a_killed_writer(path)

    write_json(path, {"a": 1})

    assert list(tmp_path.iterdir()) == [path]


def test_who_writes_the_same_file_at_the_same_time_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "config.json"

    with replacing(path) as first:
        first.write_text("first", encoding="utf-8")
        with replacing(path) as second:
            second.write_text("second", encoding="utf-8")
        assert first.read_text(encoding="utf-8") == "first"

    assert path.read_text(encoding="utf-8") == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_the_next_start_in_a_folder_removes_what_is_left_anywhere_in_it(tmp_path: Path) -> None:
    assert _left_by_a_killed_writer(tmp_path / "policy" / "config.json")
    (tmp_path / ".new-pupil" / "red").mkdir(parents=True)

    with holding(tmp_path, "run"):
        found = sorted(path.name for path in tmp_path.rglob("*"))

    assert found == [".lock", "policy"]


def test_a_folder_is_one_process_s(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with holder:
        assert holder.stdout is not None
        holder.stdout.readline()
        second = holding(tmp_path, "run")
        with pytest.raises(BusyError, match="another process is working on this run"):
            second.__enter__()
        holder.kill()

    with holding(tmp_path, "run"):  # a killed holder holds nobody up
        pass


def test_a_folder_that_is_removed_while_it_is_held_is_not_made_anew(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with holding(folder, "run"):
        write_json(folder / "one.json", {})
        shutil.rmtree(folder)

        with pytest.raises(FileNotFoundError, match="removed while it was in use"):
            write_json(folder / "policy" / "two.json", {})

        assert not folder.exists()
        folder.mkdir()
        with pytest.raises(FileNotFoundError, match="removed while it was in use"):
            write_json(folder / "two.json", {})
