from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train_settings import TrainSettings, settings_from
from hexwar_sb3.errors import FileFormatError, HexWarError


def test_each_run_gets_the_next_free_number(tmp_path: Path) -> None:
    names = [RunFolder.new(tmp_path, "commander").path.name for _ in range(2)]

    assert names == ["commander_1", "commander_2"]


def test_the_settings_of_a_run_come_back(tmp_path: Path) -> None:
    folder, settings = (
        RunFolder.new(tmp_path, "x"),
        TrainSettings(n_timesteps=7, opponents=("MA2",), runs=tmp_path),
    )

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
        ("{", "config.json: text, line 1, column 2: found Expecting property name"),
        ("[]", "config.json: file: found list; expected a run.s settings"),
        ('{"n_timestep": 7}', "config.json: n_timestep: found an unknown setting"),
        ('{"n_timesteps": "x"}', "config.json: n_timesteps: found 'x'; expected a whole number"),
        ('{"n_timesteps": 0}', "config.json: settings: found n_timesteps must be at least 1"),
        ('{"seed": null}', "config.json: seed: found None; expected a whole number"),
        ('{"seed": -1}', "config.json: settings: found seed must be in"),
        ('{"n_envs": 1000000000}', "config.json: settings: found n_envs must be at most 1024"),
        ('{"n_envs": true}', "config.json: n_envs: found True; expected a whole number or null"),
        ('{"opponents": "MA1"}', "config.json: opponents: found 'MA1'; expected a list"),
        ('{"opponents": ["self"]}', "config.json: settings: found name at least one opponent beside itself"),
        ('{"side": "green"}', "config.json: side: found 'green'; expected 'red' or 'blue' or 'both'"),
        ('{"learning_rate": NaN}', "config.json: text: found NaN, which is no number"),
        ('{"learning_rate": -1.0}', "config.json: settings: found learning_rate must be above 0"),
        ('{"runs": 7}', "config.json: runs: found 7; expected a path"),
        ('{"preset": "x"}', "config.json: settings: found unknown preset 'x'"),
        (
            '{"scenario": "a\\u0000b", "lower_scenarios": ["plain"]}',
            "config.json: settings: found unknown scenario",
        ),
        ('{"name": "../x"}', "config.json: settings: found name must be of letters"),
        ('{"seed": 1, "seed": 2}', "config.json: text: found the key 'seed' twice"),
    ],
)
def test_broken_settings_say_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "config.json").write_text(text, encoding="utf-8")

    with pytest.raises(FileFormatError, match=message):
        settings_from(RunFolder(tmp_path))


def test_nothing_but_our_errors_comes_of_bad_settings(tmp_path: Path, bad: Any) -> None:
    folder = RunFolder(tmp_path)
    folder.write_config(
        TrainSettings(n_timesteps=7, alpha=0.1, phase_ticks=(1, 2), runs=tmp_path), "hexwar train"
    )
    refused = 0
    for content in bad(json.loads(folder.config.read_text())):
        folder.config.write_bytes(content)
        try:
            settings_from(folder)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 300


def test_a_part_that_ended_before_its_first_games_counts_nothing(tmp_path: Path) -> None:
    for k, text in enumerate(("", "train/loss,x\n1,2\n", "time/time_elapsed,x\n"), start=1):
        (tmp_path / f"progress_{k}.csv").write_text(text, encoding="utf-8")

    assert RunFolder(tmp_path).minutes_before() == 0


BAD_LOGS = {
    "no number": b"time/time_elapsed,x\nsoon,1\n",
    "NaN": b"time/time_elapsed,x\nnan,1\n",
    "infinity": b"time/time_elapsed,x\n1e999,1\n",
    "a field of megabytes": b"time/time_elapsed,x\n1," + b"9" * 200_000 + b"\n",
    "no text": b"time/time_elapsed,x\n\xff\xfe,1\n",
    "more fields than the head": b"time/time_elapsed\n1,2,3\n",
    "broken off by a kill": b"time/time_elapsed,x\n60,1\n120",
    "more than 4 MB": b"time/time_elapsed\n" + b"1\n" * 3_000_000,
}


@pytest.mark.parametrize("what", BAD_LOGS)
def test_a_broken_log_is_named_and_costs_no_more_than_its_minutes(what: str, tmp_path: Path) -> None:
    (tmp_path / "progress_1.csv").write_bytes(BAD_LOGS[what])
    (tmp_path / "progress_2.csv").write_text("time/time_elapsed\n60\n", encoding="utf-8")
    with pytest.warns(UserWarning, match=r"progress_1\.csv: .*not counted"):
        assert RunFolder(tmp_path).minutes_before() == 1
