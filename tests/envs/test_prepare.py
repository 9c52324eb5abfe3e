"""Compiling ahead: said once, done once, and again after a failure."""

from __future__ import annotations

import select
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from filelock import FileLock

from hexwar_sb3.cache import Cache, cache
from hexwar_sb3.envs import prepare
from hexwar_sb3.kernels import source_hash, toolchain


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


def keep_kernel() -> str:
    """File something as a kernel of the present sources."""
    name = f"prepare.any-{source_hash(Path(prepare.__file__))}-0123456789abcdef.kernel"
    assert cache().keep(toolchain(), name, b"compiled")
    return name


def test_kernels_that_went_away_are_compiled_again_and_that_is_said(
    started: list[str], tmp_path: Path
) -> None:
    name = keep_kernel()
    prepare.prepare(print)
    prepare.prepare(print)
    assert len(started) == 3
    (tmp_path / toolchain() / name).unlink()
    said: list[str] = []
    prepare.prepare(said.append)
    assert len(started) == 6
    assert len(said) == 1


@pytest.mark.parametrize("what", ["toolchain", "source_hash"])
def test_what_another_python_or_other_sources_compiled_does_not_count(
    what: str, started: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare.prepare(print)
    monkeypatch.setattr(prepare, what, lambda *_: "kernels-fedcba9876543210")
    said: list[str] = []
    prepare.prepare(said.append)
    assert len(started) == 6
    assert len(said) == 1


def test_a_damaged_list_of_what_was_compiled_counts_as_none(started: list[str], tmp_path: Path) -> None:
    prepare.prepare(print)
    (path,) = (tmp_path / toolchain()).glob("prepared-*")
    path.write_bytes(path.read_bytes()[:-1] + b"\xff")
    prepare.prepare(print)
    assert len(started) == 6


def test_where_nothing_can_be_kept_no_process_compiles_in_vain(
    started: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Cache, "place", None)
    said: list[str] = []
    prepare.prepare(said.append)
    assert started == []
    assert len(said) == 1


def test_a_part_that_could_not_be_kept_ends_badly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(prepare, "cache", lambda: SimpleNamespace(lost={"a kernel"}))
    with pytest.raises(SystemExit) as ended:
        prepare.compile_part("look")
    assert ended.value.code == 1


def test_processes_import_the_same_package_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hexwar_sb3").mkdir()
    (tmp_path / "hexwar_sb3" / "__init__.py").write_text("raise SystemExit(5)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry])
    with prepare.start("import hexwar_sb3") as worker:
        assert worker.wait() == 0


def test_processes_end_with_the_one_that_started_them() -> None:
    """Killed, it leaves nobody who compiles on."""
    code = (
        "from hexwar_sb3.envs.prepare import start; "
        "worker = start('import time; time.sleep(600)'); print('started', flush=True); worker.wait()"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"started\n"
        parent.kill()
        closed, _, _ = select.select([parent.stdout], [], [], 60)
        assert closed  # the child held it, and is gone
        assert parent.stdout.read() == b""


@pytest.mark.parametrize("part", ["play", "look"])
def test_a_part_can_be_compiled(part: str) -> None:
    prepare.compile_part(part)


def test_of_two_that_start_together_one_waits_and_compiles_nothing(
    started: list[str], tmp_path: Path
) -> None:
    said: list[str] = []
    held = FileLock(tmp_path / prepare.LOCK.format(toolchain()))
    held.acquire()
    other = threading.Thread(target=prepare.prepare, args=(said.append,))
    other.start()
    while not said:
        time.sleep(0.01)
    assert said == ["another process is compiling the game; waiting for it"]
    assert started == []
    cache().keep(toolchain(), prepare._marker(), b"")  # it is done
    held.release()
    other.join(20)
    assert started == []
    assert len(said) == 1
