"""The public names (architecture.md, section 9)."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

import hexwar_sb3 as hx

PUBLIC = importlib.import_module("hexwar_sb3").__all__
PROMISED = [
    "Game",
    "Move",
    "Shoot",
    "Replay",
    "FrozenPolicy",
    "QMIX",
    "JointActionEnv",
    "load_map",
    "load_scenario",
    "make_vec_env",
    "play_match",
    "rules",
    "Engine",
    "SideView",
    "HexWarError",
]


@pytest.mark.parametrize("name", PROMISED)
def test_a_promised_name_is_there(name: str) -> None:
    assert name in PUBLIC
    assert getattr(hx, name).__name__.rpartition(".")[2] == name


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_can_be_imported(name: str) -> None:
    assert getattr(hx, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="Gmae"):
        _ = hx.Gmae  # type: ignore[attr-defined]


PACKAGES = sorted(path.parent.name for path in (Path(hx.__file__).parent).glob("*/__init__.pyi"))


@pytest.mark.parametrize("package", PACKAGES)
def test_a_folder_opens_with_its_public_names(package: str) -> None:
    opened = importlib.import_module(f"hexwar_sb3.{package}")

    assert opened.__all__
    for name in opened.__all__:
        assert getattr(opened, name).__class__.__name__ != "module"


def test_pages_and_notebooks_import_from_nowhere_deeper(root: Path) -> None:
    pages = [root / "README.md", *root.glob("docs/*.md"), *root.glob("examples/*.ipynb")]
    deep = [
        f"{page.name}: {found}"
        for page in pages
        for found in re.findall(r"(?:from|import) hexwar_sb3\.\w+\.[\w.]+", page.read_text(encoding="utf-8"))
    ]

    assert deep == []
