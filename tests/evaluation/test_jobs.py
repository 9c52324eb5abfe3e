"""Jobs in processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import joblib

from hexwar_sb3.evaluation.jobs import run_jobs

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
