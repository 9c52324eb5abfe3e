"""Processes that end with the one that started them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.processes import ORPHANED, PARENT

CHILD = """
import os, sys, time
from pathlib import Path
from hexwar_sb3.processes import end_with_parent
end_with_parent()
Path(sys.argv[1]).write_text(str(os.getpid()))
time.sleep(60)
"""
FATHER = """
import sys, time
from hexwar_sb3.processes import start_python
start_python(["-c", sys.argv[1], sys.argv[2]])
time.sleep(60)
"""


def wait_until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def lives(pid: int) -> bool:
    """Whether a process runs; one that ended and that nobody has asked for yet does not."""
    try:
        return not Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].startswith(" Z")
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_a_process_ends_with_its_killed_parent(tmp_path: Path) -> None:
    said = tmp_path / "pid"
    with subprocess.Popen([sys.executable, "-c", FATHER, CHILD, str(said)]) as parent:
        wait_until(lambda: said.exists() and said.read_text() != "")
        child = int(said.read_text())
        assert lives(child)
        parent.send_signal(signal.SIGKILL)

    wait_until(lambda: not lives(child), seconds=15)


def test_a_process_whose_parent_is_gone_already_ends(tmp_path: Path) -> None:
    environment = {**os.environ, PARENT: str(2**22 - 1)}
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(tmp_path / "pid")], env=environment, check=False, timeout=50
    )

    assert done.returncode == ORPHANED


def test_only_the_process_itself_is_told_of_its_parent() -> None:
    code = "import os; from hexwar_sb3.processes import *; end_with_parent(); print(os.environ.get(PARENT))"
    environment = {**os.environ, PARENT: str(os.getpid())}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True
    )

    assert done.stdout == "None\n"


FAULTS = """
import resource, sys
import numpy as np
from hexwar_sb3.processes import keep_memory
if sys.argv[1] == "keep":
    keep_memory()
np.ones(1 << 20)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(50):
    np.ones(1 << 20)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of glibc alone")
def test_memory_that_arrays_free_is_kept() -> None:
    faults = {
        how: int(subprocess.run([sys.executable, "-c", FAULTS, how], check=True, capture_output=True).stdout)
        for how in ("keep", "give back")
    }
    assert faults["keep"] < faults["give back"] / 10
