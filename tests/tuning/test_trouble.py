"""What can go wrong in a study, and what becomes of it."""

from __future__ import annotations

import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import optuna
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


@pytest.mark.parametrize(
    "content", ["{", '{"op_code": 99}\n', "[" * 100_000 + "\n", "\0\0\n", "{}\n", "[\n[]\n", "null\n"]
)
def test_a_broken_journal_is_named_and_left_as_it_is(content: str, spec: StudySpec) -> None:
    spec.folder.mkdir()
    path = spec.folder / JOURNAL
    path.write_text(content)
    for opens in (lambda: known_spec(spec.folder), lambda: begin(spec)):
        with pytest.raises(FileFormatError, match=JOURNAL):
            opens()
    assert path.read_text() == content


@pytest.mark.parametrize("lost", [1, 20])
def test_an_entry_that_was_cut_off_is_dropped(lost: int, spec: StudySpec) -> None:
    """As a kill or a power cut leaves it."""
    study = begin(spec)
    study.enqueue_trial({"alpha": 1.0})
    path = spec.folder / JOURNAL
    path.write_bytes(path.read_bytes()[:-lost])
    study = begin(spec)
    study.enqueue_trial({"alpha": 0.5})

    assert [one.system_attrs["fixed_params"]["alpha"] for one in begin(spec).trials] == [0.01, 0.5]


def test_a_process_that_is_killed_while_it_writes_holds_nobody_up(spec: StudySpec) -> None:
    begin(spec)
    hold = f"""
import os, signal
from pathlib import Path
from hexwar_sb3.tuning.store import open_storage
open_storage(Path({str(spec.folder)!r}))._backend._own_lock.acquire()
os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run([sys.executable, "-c", hold], check=False)
    assert done.returncode == -signal.SIGKILL

    begun = time.monotonic()
    begin(spec).enqueue_trial({"alpha": 0.5})
    assert time.monotonic() - begun < 10.0


def test_a_full_disk_leaves_a_journal_that_can_be_gone_on_with(spec: StudySpec) -> None:
    begin(spec)
    size = (spec.folder / JOURNAL).stat().st_size
    write = f"""
import resource, signal
from pathlib import Path
from hexwar_sb3.tuning.store import open_storage
import optuna
study = optuna.load_study(study_name="study", storage=open_storage(Path({str(spec.folder)!r})))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, ({size + 30}, {size + 30}))
try:
    study.enqueue_trial({{"alpha": 1.0}})
except OSError as error:
    print(error.strerror)
"""
    done = subprocess.run([sys.executable, "-c", write], capture_output=True, text=True, check=True)
    assert done.stdout == "File too large\n"
    assert (spec.folder / JOURNAL).stat().st_size == size

    begin(spec).enqueue_trial({"alpha": 0.5})
    assert len(begin(spec).trials) == 2


FOREIGN: dict[str, Callable[[optuna.storages.BaseStorage, str], object]] = {
    "minimized": lambda storage, name: optuna.create_study(
        storage=storage, study_name=name, direction="minimize"
    ),
    "with trials": lambda storage, name: optuna.create_study(
        storage=storage, study_name=name, direction="maximize"
    ).optimize(lambda trial: trial.suggest_float("x", 0, 1), n_trials=1),
}


@pytest.mark.parametrize("what", FOREIGN)
def test_a_study_that_is_not_ours_is_left_alone(what: str, spec: StudySpec, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'mine.db'}"
    FOREIGN[what](optuna.storages.RDBStorage(url), spec.folder.name)
    with pytest.raises(ConfigError, match="'small' is not one of `hexwar tune`"):
        begin(replace(spec, storage=url))
    theirs = optuna.load_study(storage=url, study_name=spec.folder.name)

    assert theirs.user_attrs == {}
    assert all(one.state == TrialState.COMPLETE for one in theirs.trials)


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
    "in memory": ("sqlite://", "one in memory is not shared"),
    "a brace in the password": ("postgresql+psycopg://u:sec{ret}@h/d", "its URL is not understood\n"),
    "a password for a port": ("postgresql+psycopg://u:hunter2/db", "its URL is not understood\n"),
    "a word for a number": ("sqlite:///x.db?timeout=abc", "its URL is not understood\n"),
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
