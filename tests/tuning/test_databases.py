"""Studies in databases: SQLite, and a real PostgreSQL that the test starts and stops."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from optuna.study import StudyDirection
from optuna.trial import TrialState

from hexwar_sb3.tuning.store import open_storage
from hexwar_sb3.tuning.study import StudySpec, begin, run_study
from tests.tuning.test_study import shape


def server_programs() -> Path | None:
    """Folder of PostgreSQL's programs."""
    found = shutil.which("initdb")
    places = [Path(found).parent] if found else sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    return places[-1] if places else None


@pytest.fixture
def postgres() -> Iterator[str]:
    """URL of a server that only a socket in its own folder leads to; as root it runs as nobody."""
    programs = server_programs()
    if programs is None:
        pytest.skip("needs PostgreSQL's server programs, which no extra of ours installs")
    user = "nobody" if os.geteuid() == 0 else None
    folder = Path(tempfile.mkdtemp(prefix="hexwar-pg-"))
    if user:
        shutil.chown(folder, user)

    def call(program: str, *arguments: str) -> None:
        subprocess.run(
            [programs / program, *arguments], check=True, user=user, cwd=folder, stdout=subprocess.DEVNULL
        )

    data = str(folder / "data")
    call("initdb", "--pgdata", data, "--auth", "trust", "--username", "tuner", "--no-sync")
    log = str(folder / "log")
    call("pg_ctl", "--pgdata", data, "--log", log, "--wait", "-o", f"-k {folder} -h ''", "start")
    try:
        yield f"postgresql+psycopg://tuner@/postgres?host={folder}"
    finally:
        call("pg_ctl", "--pgdata", data, "--mode", "immediate", "stop")
        shutil.rmtree(folder)


def test_sqlite_makes_the_study_of_the_journal(finished: StudySpec, spec: StudySpec) -> None:
    there = replace(spec, storage=f"sqlite:///{spec.folder.parent / 'study.db'}")
    run_study(there, 1, say=lambda _: None)

    assert shape(begin(there)) == shape(begin(finished))[:1]


@pytest.mark.filterwarnings("ignore::optuna.exceptions.ExperimentalWarning")  # threads share filters
def test_machines_may_begin_a_study_at_the_same_moment(postgres: str, tmp_path: Path) -> None:
    """All of them make the tables of an empty database: PostgreSQL refuses all but one."""
    start = threading.Barrier(4)

    def begin_at_once(number: int) -> int:
        start.wait()
        return open_storage(tmp_path, postgres).create_new_study([StudyDirection.MAXIMIZE], str(number))

    with ThreadPoolExecutor(4) as machines:
        assert sorted(machines.map(begin_at_once, range(4))) == [1, 2, 3, 4]


@pytest.mark.slow
def test_two_workers_on_postgresql(postgres: str, spec: StudySpec) -> None:
    there = replace(spec, storage=postgres)
    run_study(there, 4, workers=2, say=lambda _: None)

    trials = begin(there).trials
    assert [one.state for one in trials] == [TrialState.COMPLETE] * 4
    assert len({one.params["alpha"] for one in trials}) == 4
