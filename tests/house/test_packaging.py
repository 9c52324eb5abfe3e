"""The package: its list of folders, its links, its ways to be found (architecture.md, section 1)."""

from __future__ import annotations

import configparser
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

LINKS = ("callbacks", "policies", "tuning")


def run_python(code: str, folder: Path, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        check=False,
    )


def packages_in(root: Path) -> set[str]:
    files = (root / "hexwar_sb3").glob("**/__init__.py")
    mapped = (path for link in LINKS for path in (root / link).glob("**/__init__.py"))
    found = {".".join(path.parent.relative_to(root).parts) for path in files}
    return found | {"hexwar_sb3." + ".".join(path.parent.relative_to(root).parts) for path in mapped}


def test_setup_cfg_lists_every_package_of_the_tree(root: Path) -> None:
    config = configparser.ConfigParser()
    config.read(root / "setup.cfg", encoding="utf-8")

    listed = config["options"]["packages"].split()

    assert listed == sorted(packages_in(root))


@pytest.mark.parametrize("link", LINKS)
def test_a_mapped_folder_is_part_of_the_package(root: Path, link: str) -> None:
    place = root / "hexwar_sb3" / link

    assert place.resolve() == root / link or place.read_text(encoding="utf-8") == f"../{link}"


@pytest.mark.parametrize("link", LINKS)
def test_a_mapped_folder_refuses_to_be_a_global_package(root: Path, link: str) -> None:
    result = run_python(f"import {link}", root)

    assert f"ImportError: import hexwar_sb3.{link}, not {link}" in result.stderr


@pytest.mark.parametrize("link", LINKS)
def test_a_copy_whose_links_are_text_files_works(unlinked_copy: Path, link: str) -> None:
    result = run_python(f"import hexwar_sb3.{link} as m; print(m.__file__)", unlinked_copy)

    assert result.stderr == ""
    assert Path(result.stdout.strip()).parent == unlinked_copy / link


def test_import_is_fast_and_leaves_torch_and_numba_alone(root: Path) -> None:
    code = (
        "import sys, time; start = time.perf_counter(); import hexwar_sb3; "
        "print(time.perf_counter() - start, [m for m in ('torch', 'numba', 'matplotlib') if m in sys.modules])"
    )

    seconds, heavy = run_python(code, root).stdout.split(maxsplit=1)

    assert float(seconds) < 1.0
    assert heavy.strip() == "[]"


def test_the_game_needs_no_learning_library(root: Path) -> None:
    code = "import sys, hexwar_sb3 as hx; hx.Game; print([m for m in ('torch', 'stable_baselines3', 'matplotlib') if m in sys.modules])"

    assert run_python(code, root).stdout.strip() == "[]"


@pytest.mark.slow
def test_a_wheel_built_from_an_unlinked_copy_holds_everything(unlinked_copy: Path, root: Path) -> None:
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "--quiet",
            "--no-deps",
            "--no-build-isolation",
            "-w",
            "dist",
            ".",
        ],
        cwd=unlinked_copy,
        check=True,
    )

    names = set(zipfile.ZipFile(next((unlinked_copy / "dist").glob("*.whl"))).namelist())

    assert {f"{package.replace('.', '/')}/__init__.py" for package in packages_in(root)} <= names
    assert {f"hexwar_sb3/maps/builtin/{path.name}" for path in builtin_files(root)} <= names
    assert "hexwar_sb3/py.typed" in names
    assert "hexwar_sb3/viewer/built/page.html" in names
    assert not {name for name in names if name.split("/")[0] in {*LINKS, "tests", "examples"}}


def builtin_files(root: Path) -> list[Path]:
    return list((root / "hexwar_sb3" / "maps" / "builtin").glob("*.json"))
