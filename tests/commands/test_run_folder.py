from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train import Train, settings_from
from hexwar_sb3.errors import FileFormatError


def test_each_run_gets_the_next_free_number(tmp_path: Path) -> None:
    names = [RunFolder.new(tmp_path, "commander").path.name for _ in range(2)]

    assert names == ["commander_1", "commander_2"]


def test_the_settings_of_a_run_come_back(tmp_path: Path) -> None:
    folder, settings = RunFolder.new(tmp_path, "x"), Train(n_timesteps=7, opponents=("MA2",), runs=tmp_path)

    folder.write_config(settings, "hexwar train -n 7")

    assert settings_from(folder) == settings


def test_minutes_of_earlier_parts_count(tmp_path: Path) -> None:
    """A resumed run keeps the logs of its earlier parts as progress_k.csv."""
    for name, seconds in (("progress_1.csv", 240), ("progress_2.csv", 30), ("progress.csv", 60)):
        (tmp_path / name).write_text(f"time/time_elapsed,x\n5,\n{seconds},\n,7\n", encoding="utf-8")

    assert RunFolder(tmp_path).minutes_before() == 4.5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "config.json: text: found Expecting property name"),
        ("[]", "config.json: file: found list; expected a run.s settings"),
        ('{"n_timestep": 7}', "config.json: n_timestep: found an unknown setting"),
    ],
)
def test_broken_settings_say_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "config.json").write_text(text, encoding="utf-8")

    with pytest.raises(FileFormatError, match=message):
        settings_from(RunFolder(tmp_path))
