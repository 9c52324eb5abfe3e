"""The examples in docstrings do what they say, with the public names alone."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import hexwar_sb3 as hx

MODULES = sorted(one.name for one in pkgutil.walk_packages(hx.__path__, "hexwar_sb3."))
LOOSE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def public(name: str) -> dict[str, Any]:
    opened = importlib.import_module(name)
    return {one: getattr(opened, one) for one in getattr(opened, "__all__", ())}


def examples() -> Iterator[doctest.DocTest]:
    """Those of every module, among the package's public names, its folder's and those that it makes itself."""
    for name in MODULES:
        module = importlib.import_module(name)
        own = {k: v for k, v in vars(module).items() if getattr(v, "__module__", None) == name}
        names = public("hexwar_sb3") | public(name.rpartition(".")[0]) | own
        yield from (one for one in doctest.DocTestFinder().find(module, globs=names) if one.examples)


EXAMPLES = list(examples())


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_does_what_it_says(
    example: doctest.DocTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # some write files
    said: list[str] = []

    assert doctest.DocTestRunner(optionflags=LOOSE).run(example, out=said.append).failed == 0, "".join(said)
