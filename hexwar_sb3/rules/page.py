"""The tables of docs/rules.md, made of the rule tables: numbers stand in one place."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules import tables
from hexwar_sb3.rules.compiled import NO_EFFECT, SCATTER_HIT
from hexwar_sb3.rules.rows import AttackRow, Number, PieceRow, Table

PLACE = re.compile(r"(<!-- table: ([\w ]+) -->\n).*?(<!-- end -->\n)", re.DOTALL)


RESULT = {NO_EFFECT: ".", 0: "S"}
SIGNS = {
    "vehicle_result": RESULT,
    "soldier_result": RESULT,
    "burst_result": RESULT,
    "scatter": {SCATTER_HIT: "H", 0: "s"},
}
"""How numbers of some tables are written."""


def filled(page: str) -> str:
    """A page with every table between `<!-- table: NAME -->` and `<!-- end -->` written anew.

    Raises:
        ConfigError: there is no such table.
    """
    made = rule_tables()

    def table(place: re.Match[str]) -> str:
        name = place[2]
        if name not in made:
            raise ConfigError(f"no table {name!r}; there are {', '.join(made)}")
        return f"{place[1]}{made[name]}\n{place[3]}"

    return PLACE.sub(table, page)


def rule_tables() -> dict[str, str]:
    """Every rule table as Markdown, by its name on the page."""
    return {
        "pieces": _pieces(tables.PIECES),
        "aerocraft": _aerocraft(),
        "hops": _numbers(tables.HOPS),
        "timers": _numbers(tables.TIMERS),
        "sight": _numbers(tables.SIGHT),
        "modifiers": _numbers(tables.MODIFIERS),
        "mortar": _numbers(tables.MORTAR),
        "attacks": _attacks(tables.ATTACKS),
        **{table.name.replace("_", " "): _grid(table) for table in tables.TABLES},
    }


def _pieces(rows: Sequence[PieceRow]) -> str:
    found = []
    for row in rows:
        pools = "; ".join(
            f"{', '.join(weapon.name for weapon in pool.weapons)}: {pool.ammo}" for pool in row.pools
        )
        moving = "yes" if row.moving_fire else "no"
        numbers = (row.blood, row.value, row.armour, row.base_hop)
        found.append((row.kind.name.lower(), *numbers, moving, pools, row.source))
    heads = (
        "piece",
        "blood",
        "points each",
        "armour",
        "base hop, ticks",
        "fires moving",
        "weapons: rounds",
        "source",
    )
    return _markdown(heads, found)


def _aerocraft() -> str:
    heads = ("profile", "base hop, ticks", "sees soldiers", "sees vehicles", "is seen from", "source")
    return _markdown(
        heads,
        [
            (row.name, row.base_hop, row.soldier_cells, row.vehicle_cells, row.seen_cells, row.source)
            for row in tables.AEROCRAFT.values()
        ],
    )


def _numbers(rows: Sequence[Number]) -> str:
    return _markdown(
        ("number", "value", "unit", "source"),
        [(f"`{row.name}`", int(row.value), row.unit, row.source) for row in rows],
    )


def _attacks(rows: Sequence[AttackRow]) -> str:
    found = []
    for row in rows:
        for blood, levels in enumerate(row.levels, start=1):
            last = row.first_cells + len(levels) - 1
            found.append(
                (
                    row.weapon.name,
                    row.target.name.lower(),
                    blood if len(row.levels) > 1 else "any",
                    f"{row.first_cells} to {last}",
                    " ".join(str(level or "-") for level in levels),
                )
            )
    return _markdown(("weapon", "target", "shooter's blood", "distance", "levels"), found)


def _grid(table: Table) -> str:
    """A table of numbers as text; one of three dimensions as several."""
    signs = SIGNS.get(table.name, {})
    blocks = table.cells if len(table.first) == 3 else (table.cells,)
    text = [f"{table.name}: {table.unit}"]
    for number, block in enumerate(blocks, start=table.first[0]):  # type: ignore[arg-type]
        if len(table.first) == 3:
            text.append(f"class {number}")
        text += _lines(block, table.first[-2:], signs)
    return "\n".join(["```text", *text, "```"])


def _lines(block: object, first: Sequence[int], signs: dict[int, str]) -> list[str]:
    rows = block if isinstance(block, tuple) and isinstance(block[0], tuple) else (block,)
    columns = range(first[-1], first[-1] + len(rows[0]))
    found = ["    " + "".join(f"{column:>4}" for column in columns)]
    for number, row in enumerate(rows, start=first[0]):
        label = f"{number:>3}:" if len(rows) > 1 else "    "
        found.append(label + "".join(f"{signs.get(int(n), int(n)):>4}" for n in row))
    return found


def _markdown(heads: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    every = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in every)
