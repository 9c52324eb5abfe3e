"""What the tests of the rules share: the rule book, and a way to misprint it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from hexwar_sb3.rules import RuleSet, default_rules
from hexwar_sb3.rules.rows import Cells

Misprint = Callable[..., RuleSet]


def _changed(cells: Cells, places: tuple[int, ...], entry: int) -> Cells:
    if not places:
        return entry
    assert isinstance(cells, tuple)
    place, *rest = places
    return (*cells[:place], _changed(cells[place], tuple(rest), entry), *cells[place + 1 :])


@pytest.fixture
def rules() -> RuleSet:
    return default_rules()


@pytest.fixture
def misprint(rules: RuleSet) -> Misprint:
    """`misprint("column", 3, 8, entry=15)`: the rules with one entry of one table changed."""

    def change(name: str, *index: int, entry: int) -> RuleSet:
        table = rules.table(name)
        places = tuple(number - first for number, first in zip(index, table.first, strict=True))
        return rules.with_rows(replace(table, cells=_changed(table.cells, places, entry)))

    return change
