"""`make test-pythons` tells of each Python, and ends badly where one is missing or fails."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests import pythons

Run = Callable[..., tuple[int, list[str]]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Function that names Pythons, whose tests come out as told, and gives the exit code and the summary."""
    monkeypatch.setattr(pythons, "BUILD", tmp_path)

    def named(
        *names: str, came_out: tuple[str, bool] = ("7 passed, 1 skipped", True)
    ) -> tuple[int, list[str]]:
        monkeypatch.setattr(pythons, "_test", lambda *_: came_out)
        monkeypatch.setattr(sys, "argv", ["pythons", *names])
        return pythons.main(), capsys.readouterr().out.strip().splitlines()

    return named


def test_a_python_that_passes_is_told_with_its_version(run: Run) -> None:
    code, (line,) = run(sys.executable)

    assert code == 0
    assert line.split()[1] == pythons.version_of(sys.executable)
    assert "7 passed, 1 skipped" in line


def test_a_python_that_is_missing_is_a_failure(run: Run) -> None:
    code, lines = run(sys.executable, "no-such-python")

    assert code == 1
    assert lines[1].split()[:2] == ["no-such-python", "MISSING:"]


def test_a_python_whose_tests_fail_is_a_failure(run: Run) -> None:
    code, (line,) = run(sys.executable, came_out=("FAILED: 1 failed, 6 passed, 0 skipped", False))

    assert code == 1
    assert "FAILED: 1 failed" in line


def test_what_pytest_wrote_is_told_in_words(tmp_path: Path) -> None:
    report = tmp_path / "tests.xml"
    assert pythons._counts(report) == "no test ran"
    report.write_text('<testsuites><testsuite tests="9" skipped="2" failures="0" errors="0"/></testsuites>')
    assert pythons._counts(report) == "7 passed, 2 skipped"
    report.write_text('<testsuites><testsuite tests="9" skipped="2" failures="1" errors="1"/></testsuites>')
    assert pythons._counts(report) == "2 failed, 5 passed, 2 skipped"
