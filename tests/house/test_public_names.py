"""The public names (architecture.md, section 9)."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import hexwar_sb3 as hx

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
    assert name in hx.__all__
    assert getattr(hx, name).__name__.rpartition(".")[2] == name


@pytest.mark.parametrize("name", sorted(hx.__all__))
def test_every_public_name_can_be_imported(name: str) -> None:
    assert getattr(hx, name) is not None


def test_type_checkers_read_the_same_homes_as_python(root: Path) -> None:
    tree = ast.parse((root / "hexwar_sb3" / "__init__.py").read_text(encoding="utf-8"))
    typed = {
        alias.name: node.module
        for block in tree.body
        if isinstance(block, ast.If)  # if TYPE_CHECKING
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if node.module and node.module.startswith("hexwar_sb3.")
    }

    assert typed == {name: f"hexwar_sb3.{home}" for name, home in hx._HOMES.items()}


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Gmae'"):
        _ = hx.Gmae
