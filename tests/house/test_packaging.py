"""The package: its list of folders, its links, its ways to be found (architecture.md, section 1)."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from configparser import ConfigParser
from pathlib import Path

import pytest
import yaml

from hexwar_sb3 import __version__
from tests import pythons

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


@pytest.fixture
def config(root: Path) -> ConfigParser:
    found = ConfigParser()
    found.read(root / "setup.cfg", encoding="utf-8")
    return found


def test_setup_cfg_lists_every_package_of_the_tree(root: Path, config: ConfigParser) -> None:
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


def test_the_version_is_one_wherever_it_stands(root: Path) -> None:
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    released = re.findall(r"^## \[(\d+\.\d+\.\d+)\] - (\S+)$", changes, re.MULTILINE)[0]

    assert released == (__version__, str(citation["date-released"]))
    assert citation["version"] == __version__


def test_the_pythons_that_are_tested_are_those_that_are_named(root: Path, config: ConfigParser) -> None:
    named = re.findall(r":: (3\.\d+)$", config["metadata"]["classifiers"], re.MULTILINE)
    tested = re.search(r"^PYTHONS \?= (.*)$", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)

    assert tested
    assert tested[1].split() == [f"python{version}" for version in named]
    assert config["options"]["python_requires"] == f">={named[0]}"


def test_what_is_tested_under_every_python_is_there(root: Path) -> None:
    places = [name.partition("::") for name in pythons.TESTS]
    lost = [name for name, _, _ in places if not (root / "tests" / name).exists()]
    unknown = [
        one
        for name, _, one in places
        if one and f"def {one}(" not in (root / "tests" / name).read_text("utf-8")
    ]

    assert lost == unknown == []
    assert [name for name in pythons.BESIDE if not (root / name).exists()] == []


@pytest.mark.slow
def test_a_wheel_built_from_an_unlinked_copy_holds_every_file_of_the_package_and_no_other(
    unlinked_copy: Path, root: Path
) -> None:
    built = build(unlinked_copy, "build_wheel")

    archive = zipfile.ZipFile(built)
    names = {name for name in archive.namelist() if ".dist-info/" not in name}
    told = archive.read(f"hexwar_sb3-{__version__}.dist-info/METADATA").decode().partition("\n\n")[0]

    assert "\nLicense-Expression: MIT\n" in told

    assert names == package_files(root)
    assert "hexwar_sb3/maps/builtin/plain.map.json" in names


@pytest.mark.slow
def test_the_source_archive_holds_what_is_needed_to_build_and_to_test(tmp_path: Path, root: Path) -> None:
    copy = tmp_path / "copy"
    skip = shutil.ignore_patterns(
        *(
            "__pycache__",
            "*.egg-info",
            "node_modules",
            ".*_cache",
            ".git",
            ".venv*",
            "build",
            "dist",
            "runs",
            "site",
        ),
        "results",
    )
    shutil.copytree(root, copy, symlinks=True, ignore=skip)
    with tarfile.open(build(copy, "build_sdist")) as archive:
        sizes = {member.name.partition("/")[2]: member.size for member in archive if member.isfile()}

    tops = {name.partition("/")[0] for name in sizes}
    assert {*LINKS, "hexwar_sb3", "tests", "docs", "examples", "viewer", ".ci"} <= tops
    assert {"README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "constraints.txt", "Makefile"} <= tops
    assert {
        name.removeprefix("hexwar_sb3/") if name.split("/")[1] in LINKS else name
        for name in package_files(root)
    } <= {*sizes}
    assert {f"tests/{name}" for name in pythons.TESTS if name.endswith(".py")} <= {*sizes}
    assert not tops & {"results", "runs", "build", "dist", "site"}
    assert max(sizes.values()) < 1_500_000  # the film of the README
    assert sum(sizes.values()) < 12_000_000


def build(folder: Path, what: str) -> Path:
    """Build a wheel or a source archive there, without a network."""
    code = f"from setuptools import build_meta; print('built', build_meta.{what}('dist'))"
    done = run_python(code, folder)
    assert done.returncode == 0, done.stderr
    return folder / "dist" / done.stdout.splitlines()[-1].removeprefix("built ")


def package_files(root: Path) -> set[str]:
    """Every file of the package by its place in a wheel."""
    folders = {"hexwar_sb3": root / "hexwar_sb3"} | {f"hexwar_sb3/{link}": root / link for link in LINKS}
    return {
        f"{top}/{path.relative_to(folder).as_posix()}"
        for top, folder in folders.items()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and not is_inside_link(root, path)
    }


def is_inside_link(root: Path, path: Path) -> bool:
    """Whether a file of a mapped folder is seen by way of the package."""
    inside = path.relative_to(root).parts
    return inside[0] == "hexwar_sb3" and inside[1] in LINKS
