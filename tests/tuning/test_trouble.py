"""What can go wrong in a study, and what becomes of it."""

from __future__ import annotations

import sqlite3
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import pytest
from optuna.trial import TrialState

from hexwar_sb3.algorithms.preset_file import save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.cli import main
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.tuning import study as module
from hexwar_sb3.tuning.store import JOURNAL
from hexwar_sb3.tuning.study import REASON, StudySpec, begin, best_trial, known_spec, run_study, work


def test_a_trial_that_goes_nan_fails_and_the_study_goes_on(spec: StudySpec, tmp_path: Path) -> None:
    default = PRESETS["default"]
    wild = replace(default, learner={**default.learner, "learning_rate": 1e30, "final_learning_rate": 1e30})
    save_preset(tmp_path / "wild.json", wild, {})
    there = replace(spec, preset=str(tmp_path / "wild.json"))
    said: list[str] = []
    run_study(there, 2, say=said.append)

    first, second = begin(there).trials
    assert (first.state, second.state.is_finished()) == (TrialState.FAIL, True)
    assert "TrainingError: update" in first.user_attrs[REASON]
    assert "TrainingError" in (there.trial(0) / "error.txt").read_text()
    assert [line.partition(":")[0] for line in said] == ["trial 0", "trial 1"]


def test_a_study_without_a_completed_trial_has_no_best(spec: StudySpec) -> None:
    with pytest.raises(ConfigError, match="no trial was completed"):
        best_trial(begin(spec))


def test_a_trial_without_memory_fails_and_says_so(spec: StudySpec, monkeypatch: pytest.MonkeyPatch) -> None:
    def too_large(*_: Any) -> NoReturn:
        raise MemoryError("8 TB")

    begin(spec)
    monkeypatch.setattr(module, "objective", too_large)
    work(spec.folder)

    trial = begin(spec).trials[0]
    assert trial.state == TrialState.FAIL
    assert trial.user_attrs[REASON] == "MemoryError: 8 TB"


@pytest.mark.parametrize("content", ["{", '{"op_code": 99}\n', "[" * 100_000 + "\n", "\0\0\n"])
def test_a_broken_journal_is_named(content: str, spec: StudySpec) -> None:
    spec.folder.mkdir()
    (spec.folder / JOURNAL).write_text(content)
    with pytest.raises((FileFormatError, ConfigError), match=rf"{JOURNAL}|there is no study"):
        known_spec(spec.folder)


def test_a_locked_database_is_named(spec: StudySpec, tmp_path: Path) -> None:
    there = replace(spec, storage=f"sqlite:///{tmp_path / 'study.db'}?timeout=0.1")
    begin(there)
    other = sqlite3.connect(tmp_path / "study.db")
    other.execute("BEGIN EXCLUSIVE")
    with pytest.raises(ConfigError, match="database is locked"):
        begin(there)
    other.rollback()
    other.close()
    begin(there)


STORAGES = {
    "no such place": ("sqlite:////nowhere/at/all/study.db", "unable to open database file"),
    "no such kind": ("nosql://here", "nosql"),
    "no URL": ("study.db", "parse SQLAlchemy URL"),
    "nobody answers": ("postgresql+psycopg://x@127.0.0.1:1/x?connect_timeout=1", "the study's database: "),
}


@pytest.mark.parametrize("what", STORAGES)
def test_a_wrong_storage_is_one_line(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url, message = STORAGES[what]
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "run", str(tmp_path / "study"), "--storage", url))
    said = capsys.readouterr().err

    assert stopped.value.code == 2
    assert message in said
    assert said.count("\n") == 1
