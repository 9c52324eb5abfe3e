"""What can go wrong in a study, and what becomes of it."""

from __future__ import annotations

import shutil
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
from hexwar_sb3.errors import BusyError, ConfigError, FileFormatError
from hexwar_sb3.evaluation.opponents import OPPONENTS
from hexwar_sb3.maps.files import load_scenario, save_scenario
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tuning import study as module
from hexwar_sb3.tuning.objective import Common
from hexwar_sb3.tuning.store import JOURNAL
from hexwar_sb3.tuning.study import REASON, StudySpec, begin, best_trial, known_spec, run_study, work
from hexwar_sb3.tuning.workers import WORKER


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
    assert there.common.lower_ticks <= first.user_attrs["ticks"] < there.common.ticks / 2
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


@pytest.fixture
def ground(tmp_path: Path) -> str:
    """A scenario of another line-up: nobody flies."""
    plain = load_scenario("plain")
    pieces = tuple(piece for piece in plain.pieces if piece.kind != PieceType.AEROCRAFT)
    save_scenario(replace(plain, pieces=pieces), tmp_path / "ground.scenario.json", "plain")
    return str(tmp_path / "ground.scenario.json")


@pytest.mark.parametrize("who", ["panel", "opponents"])
def test_a_player_of_another_line_up_is_met_before_the_first_trial(
    who: str, ground: str, spec: StudySpec
) -> None:
    players: dict[str, Any] = {who: ("MA1", "HRL0")}
    there = replace(spec, common=replace(spec.common, scenario=ground, **players))
    with pytest.raises(ConfigError, match=r"HRL0.* cannot play (red|blue) of .*\(pieces, tasks"):
        run_study(there, 1, say=lambda _: None)

    assert not spec.folder.exists()


def test_a_study_on_another_line_up_meets_the_mixture_without_the_policy(ground: str) -> None:
    assert Common(scenario=ground).opponents == OPPONENTS


def test_a_study_of_which_nothing_was_completed_is_no_success(
    spec: StudySpec, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def study_of_failures(one: StudySpec, *_: Any) -> optuna.Study:
        study = begin(one)
        study.tell(study.ask(), state=TrialState.FAIL)
        return study

    monkeypatch.setattr(module, "run_study", study_of_failures)
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "run", str(spec.folder), "--panel", "MA1", "--opponents", "MA1"))

    assert stopped.value.code == 1
    assert "no trial was completed\n" in capsys.readouterr().err


@pytest.mark.parametrize("database", [None, "study.db"])
def test_a_study_that_another_process_works_on_is_left_alone(
    database: str | None, spec: StudySpec, tmp_path: Path
) -> None:
    spec = replace(spec, storage=database and f"sqlite:///{tmp_path / database}")
    study = begin(spec)
    hold = f"""
import sys
from pathlib import Path
from hexwar_sb3.folders import holding
with holding(Path({str(spec.own)!r}), "study"):
    print("held", flush=True)
    sys.stdin.read()
"""
    with subprocess.Popen(
        [sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(BusyError, match="another process is working on this study"):
            run_study(replace(spec, sampler="tpe"), 1, say=lambda _: None, points=[{"alpha": 0.5}])
        other.communicate("")

    assert len(study.trials) == 1
    assert known_spec(spec.folder, spec.storage) == spec


def wait_until(condition: Callable[[], bool], seconds: float = 120.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


RUN = """
import sys
from pathlib import Path
from hexwar_sb3.commands.console import carry_out
from hexwar_sb3.tuning.study import known_spec, run_study
def run():
    run_study(known_spec(Path(sys.argv[1])), 1)
    return 0
sys.exit(carry_out("hexwar", run))
"""


def worker_of(study: optuna.Study) -> int | None:
    """Process of the trial that runs."""
    running = study.get_trials(states=(TrialState.RUNNING,))
    return next((one.user_attrs[WORKER]["pid"] for one in running if WORKER in one.user_attrs), None)


@pytest.mark.slow
def test_the_worker_of_a_killed_study_ends_and_its_point_comes_again(spec: StudySpec) -> None:
    study = begin(spec)
    with subprocess.Popen([sys.executable, "-c", RUN, str(spec.folder)]) as parent:
        wait_until(lambda: worker_of(study) is not None)
        worker = Path("/proc") / str(worker_of(study))
        assert worker.exists()
        parent.kill()
    wait_until(lambda: not worker.exists(), seconds=15)
    run_study(spec, 1, say=lambda _: None)

    trials = begin(spec).trials
    assert [one.state for one in trials] == [TrialState.FAIL, TrialState.COMPLETE]
    assert trials[0].params == trials[1].params


@pytest.mark.slow
def test_a_study_whose_folder_is_removed_ends_and_makes_nothing(spec: StudySpec) -> None:
    study = begin(spec)
    with subprocess.Popen(
        [sys.executable, "-c", RUN, str(spec.folder)], stderr=subprocess.PIPE, text=True
    ) as parent:
        wait_until(lambda: worker_of(study) is not None)
        worker = Path("/proc") / str(worker_of(study))
        shutil.rmtree(spec.folder)
        _, said = parent.communicate(timeout=60)
    wait_until(lambda: not worker.exists(), seconds=15)

    assert parent.returncode == 2
    assert "the folder was removed while it was in use" in said.splitlines()[-1]
    assert "Traceback" not in said
    assert not spec.folder.exists()
