"""Jobs in processes."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import joblib
import pytest

from hexwar_sb3.evaluation import jobs
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.files import replacing
from hexwar_sb3.folders import holding

NAPS = """
import signal, sys, time
from pathlib import Path
from hexwar_sb3.evaluation.jobs import run_jobs

signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background were told to ignore it

def nap(place):
    Path(place).touch()
    time.sleep(60)

try:
    run_jobs(nap, sys.argv[1:], 2, "nap")
except KeyboardInterrupt:
    print("stopped")
"""


def test_the_process_that_waits_keeps_its_ctrl_c() -> None:
    before = signal.getsignal(signal.SIGINT)
    run_jobs(abs, [1, 2], 1, "number")
    with joblib.parallel_config("sequential"):
        run_jobs(abs, [1, 2], 2, "number")

    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_ends_the_jobs_without_a_word_of_theirs(tmp_path: Path) -> None:
    places = [tmp_path / "one", tmp_path / "two"]
    with subprocess.Popen(
        [sys.executable, "-c", NAPS, *map(str, places)],
        start_new_session=True,  # as a terminal's foreground: all of them get the signal
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as parent:
        end = time.monotonic() + 60
        while not all(place.exists() for place in places):
            assert time.monotonic() < end
            time.sleep(0.1)
        os.killpg(parent.pid, signal.SIGINT)
        said, complained = parent.communicate(timeout=30)

    assert said == "stopped\n"
    assert "Traceback" not in complained


def test_jobs_end_with_the_killed_process_that_waits(tmp_path: Path) -> None:
    places = [tmp_path / "one", tmp_path / "two"]
    with subprocess.Popen(
        [
            sys.executable,
            "-c",
            NAPS.replace(".touch()", ".write_text(str(__import__('os').getpid()))"),
            *map(str, places),
        ]
    ) as parent:
        end = time.monotonic() + 60
        while not all(place.exists() and place.read_text() for place in places):
            assert time.monotonic() < end
            time.sleep(0.1)
        workers = [Path("/proc") / place.read_text() for place in places]
        assert all(worker.exists() for worker in workers)
        parent.kill()

    while any(worker.exists() for worker in workers):
        assert time.monotonic() < end + 15
        time.sleep(0.1)


def touch_late(path: Path) -> None:
    """Wait until the folder is gone, and write there."""
    while path.parent.exists():
        time.sleep(0.05)
    with replacing(path):
        pass


def test_a_job_does_not_make_a_held_folder_anew(tmp_path: Path) -> None:
    folder = tmp_path / "league"
    with holding(folder, "league"):
        threading.Timer(0.5, shutil.rmtree, [folder]).start()
        with pytest.raises(FileNotFoundError, match="removed while it was in use"):
            run_jobs(touch_late, [folder / "one", folder / "two"], 2, "file")
    assert not folder.exists()


def test_no_more_processes_start_than_there_are_jobs(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[int] = []

    def parallel(n_jobs: int) -> object:
        started.append(n_jobs)
        return joblib.Parallel(n_jobs=1)

    monkeypatch.setattr(jobs, "Parallel", parallel)

    assert run_jobs(abs, [-1, -2], 10**9, "number") == [1, 2]
    assert run_jobs(abs, [], 10**9, "number") == []
    assert started == [2, 1]
