"""What jobs cost."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from time import process_time, sleep
from typing import Any

import pytest

from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.league.cost import FILE, added, measured, read_cost

NUMBERS = range(30_000_000)  # they take some time to add up


def _add_up(numbers: range) -> float:
    """Seconds of the processor that a sum took here."""
    start = process_time()
    sum(numbers)
    return process_time() - start


def test_parts_add_up_and_others_stay(tmp_path: Path) -> None:
    sums = 0.0
    for _ in range(2):
        with measured(tmp_path, "groups"):
            sums += sum(run_jobs(_add_up, [NUMBERS] * 2, 2, "sum"))
    with measured(tmp_path, "matches"):
        sleep(0.1)

    found = read_cost(tmp_path)
    # Each of the two parts is rounded; starting the workers and sending counts too.
    assert sums - 0.1 <= found["groups"]["core_s"] < sums + 2
    assert found["matches"]["core_s"] < found["matches"]["wall_s"]  # it slept
    assert found["matches"]["peak_mb"] > 0


WORKER = """
import subprocess, sys
from hexwar_sb3.league.cost import peak_mb

held = "block = bytearray(1_500_000_000); print(flush=True); input()"
with subprocess.Popen([sys.executable, "-c", held], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as worker:
    worker.stdout.readline()
    print(peak_mb())
    worker.communicate(b"\\n")
print(peak_mb())
"""


@pytest.mark.skipif(
    not Path("/proc").is_dir(),
    reason="only Linux tells the peak memory of other processes; elsewhere peak_mb is promised for its own alone",
)
def test_memory_is_that_of_the_largest_process() -> None:
    said = subprocess.run([sys.executable, "-c", WORKER], check=True, capture_output=True, text=True).stdout
    during, after = (float(line) for line in said.split())

    assert during > 1_500 > after


def test_what_breaks_off_has_cost_all_the_same(tmp_path: Path) -> None:
    def broken_off() -> None:
        summands: list[Any] = [NUMBERS, "broken"]
        with measured(tmp_path, "groups"):
            run_jobs(sum, summands, 2, "sum")

    with pytest.raises(TypeError):
        broken_off()

    assert read_cost(tmp_path)["groups"]["core_s"] > 0


@pytest.mark.parametrize("text", ["", "{", "7"])
def test_a_broken_file_says_nothing(text: str, tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(text)

    assert read_cost(tmp_path) == {}


def test_costs_of_folders_add_up_part_by_part() -> None:
    one = {"groups": {"wall_s": 1.0, "core_s": 2.0, "peak_mb": 9.0}}
    other = {"groups": {"wall_s": 2.0, "core_s": 4.0, "peak_mb": 5.0}, "heirs": {"wall_s": 7.0}}

    assert added([one, other, {}]) == {
        "groups": {"wall_s": 3.0, "core_s": 6.0, "peak_mb": 9.0},
        "heirs": {"wall_s": 7.0},
    }
    assert one["groups"]["wall_s"] == 1.0
