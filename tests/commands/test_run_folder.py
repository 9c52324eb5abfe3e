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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "config.json: file: found Expecting property name"),
        ("[]", "config.json: file: found list; expected a JSON object"),
        ('{"n_timestep": 7}', "config.json: n_timestep: found an unknown setting"),
    ],
)
def test_broken_settings_say_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "config.json").write_text(text, encoding="utf-8")

    with pytest.raises(FileFormatError, match=message):
        settings_from(RunFolder(tmp_path))
