"""Compiled kernels: kept by all that they depend on, never stale, never in the way of others."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
import pytest

from hexwar_sb3 import kernels
from hexwar_sb3.cache import cache
from hexwar_sb3.kernels import COMPILED, READ, Rows, counts, kernel, source_hash, toolchain

pytestmark = pytest.mark.skipif(not kernels.compiles(), reason="nothing is compiled")
NUMBERS = np.arange(5.0)


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder of the test's own."""
    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def total(values: Rows) -> float:
    """A kernel to be."""
    found = 0.0
    for i in range(values.size):
        found += values[i]
    return found


def longest(values: Rows) -> float:
    """Another one."""
    return float(values.size)


def use(function: Callable[[Rows], float] = total) -> dict[str, int]:
    """Start anew with a kernel; what was read and compiled."""
    before = counts.copy()
    assert kernel(function)(NUMBERS) == function(NUMBERS)
    return dict(counts - before)


def files(folder: Path) -> list[Path]:
    return sorted((folder / toolchain()).glob("*.kernel"))


@pytest.mark.usefixtures("own_cache")
def test_a_kernel_is_compiled_once_and_then_read() -> None:
    assert use() == {COMPILED: 1}
    assert use() == {READ: 1}
    assert use(longest) == {COMPILED: 1}


def times(factor: int) -> Callable[[Rows], float]:
    """A kernel to be, made by another function."""

    def product(values: Rows) -> float:
        return float(values[1] * factor)

    return product


@pytest.mark.usefixtures("own_cache")
def test_kernels_that_another_function_makes_are_told_apart() -> None:
    assert use(times(2)) == {COMPILED: 1}
    assert use(times(3)) == {COMPILED: 1}
    assert use(times(2)) == {READ: 1}


class Planted:
    """What a stranger would like to be unpickled."""

    def __reduce__(self) -> tuple[Callable[[str], int], tuple[str]]:
        return os.system, ("touch planted",)


DAMAGE: dict[str, Callable[[bytes, bytes], bytes]] = {
    "nothing": lambda _, __: b"",
    "garbage": lambda _, __: os.urandom(3000),
    "half": lambda old, _: old[: len(old) // 2],
    "one bit": lambda old, _: old[:-99] + bytes([old[-99] ^ 1]) + old[-98:],
    "another kernel": lambda _, other: other,
    "a pickle": lambda _, __: pickle.dumps(Planted()),
    "a pickle behind the head": lambda old, _: old[:4096] + pickle.dumps(Planted()),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_is_compiled_anew(
    damage: str, own_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    use()
    (mine,) = files(own_cache)
    use(longest)
    (other,) = set(files(own_cache)) - {mine}
    mine.write_bytes(DAMAGE[damage](mine.read_bytes(), other.read_bytes()))
    assert use() == {COMPILED: 1}
    assert use() == {READ: 1}
    assert not (tmp_path / "planted").exists()


def test_whole_files_that_this_numba_cannot_read_are_compiled_anew(own_cache: Path) -> None:
    use()
    (mine,) = files(own_cache)
    for content in (b"", b"no pickle", pickle.dumps(1), pickle.dumps((1, 2, 3)), pickle.dumps(())):
        assert cache().keep(toolchain(), mine.name, content)
        assert use() == {COMPILED: 1}


def test_numbas_own_settings_and_others_kernels_are_left_alone(own_cache: Path, tmp_path: Path) -> None:
    """A function of somebody else's is cached where it would be without us."""
    theirs = tmp_path / "theirs.py"
    theirs.write_text("import numba\n@numba.njit(cache=True)\ndef one(): return 1\n")
    code = "import hexwar_sb3.engine.step, numba, theirs; theirs.one(); print(repr(numba.config.CACHE_DIR))"
    env = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    env["PYTHONPATH"] = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    run = subprocess.run(
        [sys.executable, "-P", "-c", code], env=env, capture_output=True, text=True, check=True
    )
    assert run.stdout == "''\n"
    assert list((tmp_path / "__pycache__").glob("theirs.one-*.nbi"))
    assert not list(own_cache.rglob("*theirs*"))


def in_process(code: str, **env: str) -> str:
    """Run code in a process of its own; what it prints."""
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTHONDONTWRITEBYTECODE": "1",
        **env,
    }
    run = subprocess.run(
        [sys.executable, "-P", "-c", code], env=env, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


@pytest.mark.parametrize(
    "settings",
    [{"NUMBA_OPT": "1"}, {"NUMBA_BOUNDSCHECK": "1"}, {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}],
    ids=str,
)
def test_kernels_of_another_processor_or_other_settings_lie_elsewhere(settings: dict[str, str]) -> None:
    code = "from hexwar_sb3.kernels import toolchain; print(toolchain())"
    assert in_process(code) == toolchain()
    assert in_process(code, **settings) != toolchain()


@pytest.mark.parametrize(
    ("of", "name", "value"),
    [(numba, "__version__", "0.0.1"), (np, "__version__", "9.9"), (llvmlite, "__version__", "0.1"),
     (sys.implementation, "cache_tag", "cpython-399")],
)  # fmt: skip
def test_kernels_of_another_python_or_package_lie_elsewhere(
    of: object, name: str, value: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = toolchain.__wrapped__()
    monkeypatch.setattr(of, name, value)
    assert toolchain.__wrapped__() != here


PACKAGE = {
    "hexwar_sb3/numbers.py": "FACTOR = 2\n",
    "hexwar_sb3/other.py": "ELSE = 2\n",
    "hexwar_sb3/near.py": "from hexwar_sb3.kernels import kernel\nfrom hexwar_sb3.numbers import FACTOR\n"
    "@kernel\ndef times(x): return x * FACTOR\n",
    "hexwar_sb3/far.py": "from hexwar_sb3.kernels import kernel\nfrom hexwar_sb3.near import times\n"
    "@kernel\ndef more(x): return times(x) + 1\n",
}


@pytest.fixture
def checkouts(tmp_path: Path) -> Callable[[str], Path]:
    """Make a small package with our kernels.py in a folder of its own."""
    import hexwar_sb3

    ours = Path(hexwar_sb3.__file__).parent

    def make(name: str) -> Path:
        folder = tmp_path / name
        for path, text in PACKAGE.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text)
        for file in ("kernels.py", "cache.py", "errors.py", "files.py", "reading.py"):
            (folder / "hexwar_sb3" / file).write_bytes((ours / file).read_bytes())
        (folder / "hexwar_sb3" / "__init__.py").write_text("")
        return folder

    return make


def more(folder: Path, kept: Path) -> tuple[int, int, int]:
    """Result of the kernel in a checkout; kernels read and compiled."""
    code = (
        "from hexwar_sb3.far import more; from hexwar_sb3.kernels import counts; "
        "print(more(5), counts['read'], counts['compiled'])"
    )
    found = in_process(code, PYTHONPATH=str(folder), HEXWAR_CACHE=str(kept)).split()
    return int(found[0]), int(found[1]), int(found[2])


def test_a_stale_kernel_is_never_used_and_an_edit_elsewhere_compiles_nothing(
    checkouts: Callable[[str], Path], tmp_path: Path
) -> None:
    here = checkouts("here")
    assert more(here, tmp_path / "cache") == (11, 0, 2)
    assert more(here, tmp_path / "cache") == (11, 1, 0)
    (here / "hexwar_sb3" / "other.py").write_text("ELSE = 3\n")
    assert more(here, tmp_path / "cache") == (11, 1, 0)
    (here / "hexwar_sb3" / "numbers.py").write_text("FACTOR = 3\n")
    assert more(here, tmp_path / "cache") == (16, 0, 2)
    (here / "hexwar_sb3" / "numbers.py").write_text("FACTOR = 2\n")
    assert more(here, tmp_path / "cache") == (11, 1, 0)


def test_another_checkout_with_the_same_sources_compiles_nothing(
    checkouts: Callable[[str], Path], tmp_path: Path
) -> None:
    assert more(checkouts("one"), tmp_path / "cache") == (11, 0, 2)
    assert more(checkouts("two"), tmp_path / "cache") == (11, 1, 0)


def test_processes_that_compile_at_the_same_time_leave_whole_files(
    checkouts: Callable[[str], Path], tmp_path: Path
) -> None:
    here, kept = checkouts("here"), tmp_path / "cache"
    code = "from hexwar_sb3.far import more; assert more(5) == 11"
    env = {**os.environ, "PYTHONPATH": str(here), "HEXWAR_CACHE": str(kept)}
    crowd = [subprocess.Popen([sys.executable, "-P", "-c", code], env=env) for _ in range(3)]
    assert [one.wait() for one in crowd] == [0] * 3
    assert more(here, kept) == (11, 1, 0)
    assert not list(kept.rglob(".new-*"))


def test_a_file_depends_on_what_it_imports_and_not_on_the_cache() -> None:
    from hexwar_sb3.maps import terrain

    sources = kernels.sources_of(Path(terrain.__file__))
    assert {Path(terrain.__file__), Path(kernels.__file__)} <= sources
    assert Path(kernels.__file__).with_name("cache.py") not in sources
    assert len(source_hash(Path(terrain.__file__))) == 16
