"""The site (`make site`): it says every public name, asks nobody outside, and is not built where something is broken."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import hexwar_sb3 as hx
from hexwar_sb3.evaluation import Estimate

NOT_SOURCES = (".git", ".venv", "runs", "site", "build", "api", "__pycache__", "*_cache", "*.egg-info")


@pytest.fixture(scope="module")
def conf(root: Path) -> dict[str, Any]:
    return runpy.run_path(str(root / "docs" / "conf.py"))


def test_every_public_name_says_what_it_is(conf: dict[str, Any]) -> None:
    assert conf["undocumented"]() == []


@pytest.mark.parametrize(
    ("silent", "names"),
    [
        (Estimate, ["hexwar_sb3.evaluation.Estimate"]),
        (hx.load_map, ["hexwar_sb3.load_map", "hexwar_sb3.maps.load_map"]),
    ],
)
def test_a_public_name_that_says_nothing_is_found(
    conf: dict[str, Any], monkeypatch: pytest.MonkeyPatch, silent: object, names: list[str]
) -> None:
    monkeypatch.setattr(silent, "__doc__", None)

    assert conf["undocumented"]() == names


def test_a_value_says_what_the_string_below_it_says(conf: dict[str, Any]) -> None:
    said, home = conf["said"], "hexwar_sb3.algorithms.presets"

    assert said("hexwar_sb3.algorithms", "PRESETS", home).startswith("Presets by name")
    assert said("hexwar_sb3.players.terms", "USUAL", "hexwar_sb3.players.terms") == ""


@pytest.fixture
def copy(root: Path, tmp_path: Path) -> Path:
    return shutil.copytree(
        root, tmp_path / "copy", symlinks=True, ignore=shutil.ignore_patterns(*NOT_SOURCES)
    )


def build(copy: Path) -> subprocess.CompletedProcess[str]:
    """As `make site` builds it."""
    command = "-m sphinx -q -E -W --keep-going -c docs -d build/doctrees . site"
    return subprocess.run(
        [sys.executable, *command.split()], cwd=copy, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_the_site_shows_everything_and_asks_nobody(copy: Path, conf: dict[str, Any]) -> None:
    done = build(copy)
    assert (done.returncode, done.stderr) == (0, "")

    site = copy / "site"
    for source in [*copy.glob("*.md"), *copy.glob("docs/**/*.md"), *copy.glob("examples/*.ipynb")]:
        assert (site / source.relative_to(copy)).with_suffix(".html").exists()
    for folder in conf["folders"]():
        page = (site / "docs" / "api" / f"{folder}.html").read_text("utf-8")
        assert [name for name in conf["homes"](folder) if f'.{name}"' not in page] == ["rules"] * (
            folder == "hexwar_sb3"
        )
    fetched = r'<(?:script|img|iframe)[^>]* src="(?:https?:)?//|<link[^>]* href="(?:https?:)?//|url\(["\']?(?:https?:)?//'
    files = [*site.rglob("*.html"), *site.rglob("*.css")]
    assert [file.name for file in files if re.search(fetched, file.read_text("utf-8"))] == []


@pytest.mark.slow
def test_broken_links_end_the_build(copy: Path) -> None:
    lost = "nowhere"
    links = [f"{lost}.md", f"rules.md#{lost}", f"../results/{lost}/"]
    with (copy / "docs" / "seeds.md").open("a", encoding="utf-8") as page:
        page.writelines(f"\n[A way]({link}).\n" for link in links)

    done = build(copy)

    assert done.returncode != 0
    assert len(re.findall(rf"docs/seeds\.md:\d+: WARNING: .*{lost}", done.stderr)) == len(links)


@pytest.mark.slow
def test_an_undocumented_name_ends_the_build(copy: Path) -> None:
    (copy / "hexwar_sb3" / "maps" / "planted.py").write_text("def silent() -> None: ...\n", "utf-8")
    with (copy / "hexwar_sb3" / "maps" / "__init__.pyi").open("a", encoding="utf-8") as stub:
        stub.write("from .planted import silent as silent\n")

    done = build(copy)

    assert done.returncode != 0
    assert "no docstring: hexwar_sb3.maps.silent" in done.stderr
