"""No number of the rules is typed outside rules/tables.py (CONTRIBUTING.md, "Change or add a rule")."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

LAYERS = ("engine", "tasks", "envs", "play")
COUNTING = {0, 1, 2, -1, 0.5}
BITS = {3, 7, 8}  # `b >> 3` and `b & 7` find the bit of cell b in a row of the line-of-sight table
SIDES = {6}  # of a hexagon
COLUMNS = {"at", "N_TASKS", "n0"}  # `out[at + 5]`: a column of the feature table, the number of a draw
DRAWING = {"picture.py"}  # sizes of ink

# Numbers that stand in a function of these files, and are none of the rules.
ALLOWED: dict[str, set[float]] = {
    "engine/dice.py": {128},  # packs tick, kind and draw into the key of a die
    "engine/fire.py": {100},  # keeps a sum of losses within its byte
    "engine/legality.py": {5},  # the last direction
    "engine/record.py": {16},  # digits of a hash
    "engine/replay_file.py": {40},  # characters of a wrong line in a message
    "engine/state.py": {2**64 - 1},  # a seed has 64 bits
    "engine/text.py": {4},  # digits of a cell's name
    "play/fingerprint.py": {4, *range(5, 16)},  # which multiplier of a fingerprint
    "play/warm_start.py": {1e-9},  # rounding of a cross product
    "tasks/sets.py": {4},  # columns of a draft
}


class Numbers(ast.NodeVisitor):
    """Collects the numbers in function bodies; a named constant of the module has told what it is."""

    def __init__(self) -> None:
        self.found: list[tuple[int, float]] = []
        self._depth = 0

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._depth += 1
        for statement in node.body:
            self.visit(statement)
        self._depth -= 1

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not (isinstance(node.op, ast.Add) and is_column(node.left)):
            self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if not (isinstance(node.op, ast.Add) and is_column(node.target)):
            self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if self._depth and isinstance(node.value, int | float):
            self.found.append((node.lineno, node.value))


def is_column(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id in COLUMNS


def numbers_in_functions(source: str) -> Iterator[tuple[int, float]]:
    visitor = Numbers()
    visitor.visit(ast.parse(source))
    yield from visitor.found


def sources() -> list[Path]:
    package = Path(__file__).parents[2] / "hexwar_sb3"
    return [
        path
        for layer in LAYERS
        for path in sorted((package / layer).rglob("*.py"))
        if path.name not in DRAWING
    ]


@pytest.mark.parametrize("path", sources(), ids=lambda path: "/".join(path.parts[-2:]))
def test_no_function_holds_a_number_of_the_rules(path: Path) -> None:
    fine = COUNTING | BITS | SIDES | ALLOWED.get("/".join(path.parts[-2:]), set())

    numbers = numbers_in_functions(path.read_text(encoding="utf-8"))

    assert [(line, number) for line, number in numbers if number not in fine] == []


def test_a_planted_rule_number_is_found() -> None:
    planted = "STOP = 75\ndef stop(piece, tick, at):\n    piece.stop_ends = tick + 75\n    out[at + 9] = 1\n"

    assert (3, 75) in list(numbers_in_functions(planted))
    assert not {1, 4} & {line for line, number in numbers_in_functions(planted) if number > 8}
