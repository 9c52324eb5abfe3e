"""Folders that one process at a time works in."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hexwar_sb3.errors import BusyError
from hexwar_sb3.files import UNFINISHED, replacing
from hexwar_sb3.folders import LOCK, held, holding, making

OTHER = """
import sys
from pathlib import Path
from hexwar_sb3.errors import BusyError
from hexwar_sb3.folders import holding
try:
    with holding(Path(sys.argv[1]), "league"):
        print("held")
except BusyError as error:
    print(error)
"""


def another(folder: Path) -> str:
    """What another process gets that wants to hold a folder."""
    return subprocess.run(
        [sys.executable, "-c", OTHER, str(folder)], check=True, capture_output=True, text=True
    ).stdout


def test_a_folder_is_held_by_one_process_until_the_block_ends(tmp_path: Path) -> None:
    with holding(tmp_path / "here", "league"):
        assert (
            another(tmp_path / "here") == f"{tmp_path / 'here'}: another process is working on this league\n"
        )
    assert another(tmp_path / "here") == "held\n"


def test_who_holds_a_folder_holds_those_below_and_itself_again(tmp_path: Path) -> None:
    with holding(tmp_path, "league"):
        with holding(tmp_path, "league"), holding(tmp_path / "matches", "tournament"):
            assert [*held()] == [tmp_path.resolve()]
        assert another(tmp_path).endswith("another process is working on this league\n")
    assert held() == {}


def test_a_block_that_fails_lets_the_folder_go(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no luck"), holding(tmp_path, "league"):
        raise ValueError("no luck")
    assert another(tmp_path) == "held\n"


@pytest.mark.parametrize("is_made_again", [False, True])
def test_nothing_is_made_in_a_held_folder_that_was_removed(is_made_again: bool, tmp_path: Path) -> None:
    folder = tmp_path / "league"
    with holding(folder, "league"):
        shutil.rmtree(folder)
        if is_made_again:
            folder.mkdir()
        for attempt in (
            lambda: making(folder / "groups" / "one").__enter__(),
            lambda: holding(folder / "matches", "tournament").__enter__(),
            lambda: replacing(folder / "table.json").__enter__(),
        ):
            with pytest.raises(FileNotFoundError, match="removed while it was in use"):
                attempt()
    assert folder.exists() == is_made_again
    assert not is_made_again or not any(folder.iterdir())


def test_a_folder_that_is_being_made_is_there_whole_or_not_at_all(tmp_path: Path) -> None:
    with making(tmp_path / "groups" / "one") as made:
        (made / "file").touch()
        assert not (tmp_path / "groups" / "one").exists()
    with pytest.raises(ValueError, match="no luck"), making(tmp_path / "groups" / "two"):
        raise ValueError("no luck")

    assert [path.name for path in (tmp_path / "groups").iterdir()] == ["one"]
    assert [path.name for path in (tmp_path / "groups" / "one").iterdir()] == ["file"]


def test_what_killed_processes_were_making_goes_away_at_the_next_start(tmp_path: Path) -> None:
    for left in (tmp_path / f"{UNFINISHED}a.npz", tmp_path / "deep" / "er" / f"{UNFINISHED}b" / "file.json"):
        left.parent.mkdir(parents=True, exist_ok=True)
        left.touch()
    (tmp_path / "kept").touch()
    with holding(tmp_path, "run"):
        pass

    assert {path.name for path in tmp_path.rglob("*")} == {LOCK, "deep", "er", "kept"}
    with pytest.raises(BusyError), holding(tmp_path, "run"):
        raise BusyError("of the block's own")
