"""Compiling ahead: said once, done once, and again after a failure."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from hexwar_sb3.envs import prepare


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[str]:
    """Code of the processes that were started; none of them compiles anything."""
    codes: list[str] = []

    def start(code: str) -> subprocess.Popen[bytes]:
        codes.append(code)
        return subprocess.Popen([sys.executable, "-c", "raise SystemExit(0)"])

    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path))
    monkeypatch.setattr(prepare, "start", start)
    return codes


def test_the_first_start_compiles_and_says_so_and_the_second_does_not(started: list[str]) -> None:
    said: list[str] = []
    prepare.prepare(said.append)
    prepare.prepare(said.append)
    assert len(said) == 1
    assert [code for code in started if "compile_part" in code] == started[1:]
    assert len(started) == 3


def test_what_failed_is_tried_again(started: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    fails = [sys.executable, "-c", "raise SystemExit(1)"]
    with monkeypatch.context() as failing:
        failing.setattr(prepare, "start", lambda _code: subprocess.Popen(fails))
        prepare.prepare(print)
    prepare.prepare(print)
    assert len(started) == 3


def test_without_compilation_there_is_nothing_to_do(
    started: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(prepare, "compiles", lambda: False)
    prepare.prepare(print)
    assert started == []


@pytest.mark.parametrize("part", ["play", "look"])
def test_a_part_can_be_compiled(part: str) -> None:
    prepare.compile_part(part)
