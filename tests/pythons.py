"""The installed package under several Pythons: `make test-pythons`.

Each Python has a virtual environment of its own in build/. The package is installed there as the wheel that users get,
and tested from a copy of the tests beside which no sources lie. What is tested is chosen to be wide and quick: games to
the bit, files, learning on small games, the command line, export, the server of `hexwar play`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from xml.etree import ElementTree as ET

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "build"
BESIDE = ("docs", "examples", "setup.cfg", "tests")  # what the tests read
TESTS = (
    *("rules", "test_cache.py", "test_files.py", "test_folders.py", "test_kernels.py", "test_kinds.py"),
    *("test_processes.py", "test_reading.py", "test_records.py"),
    *("maps/test_map_file.py", "maps/test_scenario.py", "maps/test_generator.py"),
    *("engine/test_playthroughs.py", "engine/test_replay.py", "engine/test_replay_versions.py"),
    *("bots/test_hash.py", "play/test_recording.py", "play/test_reenact.py"),
    *("envs/test_task_env.py", "envs/test_joint_action.py", "envs/test_parallel.py"),
    "algorithms/test_qmix.py::test_it_plays_valid_tasks_only_and_changes_its_weights",
    "algorithms/test_qmix.py::test_two_runs_of_one_seed_are_equal",
    *("algorithms/test_td_targets.py", "algorithms/test_model_file.py"),
    *("players/test_policy_file.py", "players/test_frozen.py", "policies/test_mixers.py"),
    *("commands/test_cli.py", "server/test_app.py", "viewer/test_page.py"),
)
OF_SOURCES = "tests/viewer/test_page.py::test_the_pages_are_built_of_the_sources_that_are_here"
Row = tuple[str, str, str, bool]  # as called, its version, what came out, whether all is well


def main() -> int:
    """Test under each Python that is named, print one line for each; 1 if one is missing or fails."""
    parser = argparse.ArgumentParser(prog="tests.pythons", description=__doc__)
    parser.add_argument("pythons", nargs="+", metavar="PYTHON", help="name or path of an interpreter")
    parser.add_argument("--jobs", type=int, default=2, help="processes that test side by side")
    given = parser.parse_args()
    shutil.rmtree(BUILD / "wheel", ignore_errors=True)
    rows = [_row(python, given.jobs) for python in given.pythons]
    print()
    for name, version, said, _ in rows:
        print(f"{name:<12} {version:<9} {said}")
    return 0 if all(well for *_, well in rows) else 1


def _row(python: str, jobs: int) -> Row:
    name, version, start = Path(python).name, version_of(python), perf_counter()
    if not version:
        return python, "", "MISSING: it is not installed, or does not run", False
    try:
        said, well = _test(python, version, jobs)
    except subprocess.CalledProcessError as error:
        said, well = f"FAILED: {' '.join(map(str, error.cmd[:4]))} ... ended with {error.returncode}", False
    return name, version, f"{said}, {perf_counter() - start:.0f} s", well


def version_of(python: str) -> str:
    """Version of an interpreter, such as "3.12.1"; empty if it does not run."""
    code = "import platform; print(platform.python_version())"
    try:
        return subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def _test(python: str, version: str, jobs: int) -> tuple[str, bool]:
    """Install the wheel, look at it, run the tests; what came out, and whether all is well."""
    folder = BUILD / f"python-{version.rpartition('.')[0]}"
    own = {**os.environ, "PYTHONPATH": "", "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    print(f"\n{python}, {version}: installing into {folder}", flush=True)
    _install(python, folder, own)
    tree, report = _tree(folder), folder / "tests.xml"
    subprocess.run([folder / "bin" / "hexwar", "doctor"], check=True, cwd=tree, env=own)
    report.unlink(missing_ok=True)
    pytest = [
        str(folder / "bin" / "python"),
        "-m",
        "pytest",
        "-q",
        f"--junitxml={report}",
        "-m",
        "not slow",
        f"--deselect={OF_SOURCES}",
    ]
    pytest += ["-n", str(jobs), "--dist", "loadgroup", *(f"tests/{name}" for name in TESTS)]
    ended = subprocess.run(pytest, check=False, cwd=tree, env=own)
    return ("FAILED: " if ended.returncode else "") + _counts(report), ended.returncode == 0


def _install(python: str, folder: Path, own: dict[str, str]) -> None:
    """Install the wheel and what its tests need into an environment that is there, or is made."""
    if not (folder / "bin" / "python").exists():
        subprocess.run([python, "-m", "venv", folder], check=True)
    pip = [str(folder / "bin" / "python"), "-m", "pip", "--disable-pip-version-check"]
    wheel = _wheel(pip)
    install = [*pip, "install", "--quiet", "-c", str(ROOT / "constraints.txt")]
    if index := os.environ.get("TORCH_INDEX"):
        subprocess.run([*install, "--no-deps", "--index-url", index, "torch"], check=True, env=own)
    subprocess.run([*install, f"{wheel}[test]"], check=True, env=own)
    subprocess.run([*install, "--no-deps", "--force-reinstall", wheel], check=True, env=own)
    subprocess.run([*pip, "check"], check=True, env=own)


def _wheel(pip: Sequence[str]) -> Path:
    """The wheel, built by the first who asks; it is the same for all Pythons."""
    folder = BUILD / "wheel"
    if not folder.exists():
        shutil.rmtree(BUILD / "lib", ignore_errors=True)  # of an earlier build, with files that are gone
        subprocess.run([*pip, "wheel", "--quiet", "--no-deps", "-w", folder, ROOT], check=True)
    return next(folder.glob("*.whl"))


def _tree(folder: Path) -> Path:
    """A copy of the tests and of what they read, without the package's sources."""
    tree = folder / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    for name in BESIDE:
        place = ROOT / name
        if place.is_dir():
            shutil.copytree(place, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(place, tree / name)
    return tree


def _counts(report: Path) -> str:
    """What pytest wrote of a run, in words."""
    if not report.exists():
        return "no test ran"
    suites = list(ET.parse(report).getroot())  # noqa: S314  written by our own run
    kinds = ("tests", "skipped", "failures", "errors")
    tests, skipped, *bad = (sum(int(suite.get(kind, 0)) for suite in suites) for kind in kinds)
    failed = f"{sum(bad)} failed, " if any(bad) else ""
    return f"{failed}{tests - skipped - sum(bad)} passed, {skipped} skipped"


if __name__ == "__main__":
    sys.exit(main())
