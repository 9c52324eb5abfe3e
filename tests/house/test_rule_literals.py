"""No number of the rules is typed outside rules/tables.py (style.md, "Where numbers live")."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

LAYERS = ("engine", "tasks", "envs", "play")
# Counting, halving, signs; one bit and one byte of a mask.
PLAIN = {0, 1, 2, -1, 0.5}
BITS = {3, 7, 8}
"""`b >> 3` and `b & 7` find the bit of cell b in a row of the line-of-sight table."""

# file: numbers that stand in a function there, each with its reason
ALLOWED: dict[str, set[float]] = {}


def numbers_in_functions(path: Path) -> Iterator[tuple[int, float]]:
    """Numbers typed in function bodies; a named constant of the module has told what it is."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for statement in function.body:
                for node in ast.walk(statement):
                    if isinstance(node, ast.Constant) and type(node.value) in {int, float}:
                        yield node.lineno, node.value


def sources() -> list[Path]:
    package = Path(__file__).parents[2] / "hexwar_sb3"
    return [path for layer in LAYERS for path in sorted((package / layer).rglob("*.py"))]


@pytest.mark.parametrize("path", sources(), ids=lambda path: "/".join(path.parts[-2:]))
def test_no_function_holds_a_number_of_the_rules(path: Path) -> None:
    fine = PLAIN | BITS | ALLOWED.get("/".join(path.parts[-2:]), set())

    assert [(line, number) for line, number in numbers_in_functions(path) if number not in fine] == []
