"""docs/equations.md: each row names a symbol whose docstring names the equation."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "equations.md"
ROW = re.compile(r"^\| (?P<equation>[^|]+?) \| `(?P<symbol>[\w.]+)` \|", re.MULTILINE)


def rows() -> list[tuple[str, str]]:
    return [(m["equation"], m["symbol"]) for m in ROW.finditer(PAGE.read_text(encoding="utf-8"))]


def resolve(symbol: str) -> object:
    """Find `package.module.name` or `package.module.Class.method`."""
    parts = symbol.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        try:
            found: object = import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for name in parts[cut:]:
            found = getattr(found, name)
        return found
    raise AssertionError(f"no module in {symbol}")


def test_the_page_has_rows() -> None:
    assert len(rows()) >= 3


@pytest.mark.parametrize(("equation", "symbol"), rows())
def test_the_docstring_of_the_symbol_names_the_equation(equation: str, symbol: str) -> None:
    assert equation in (resolve(symbol).__doc__ or "")
