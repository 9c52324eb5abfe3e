"""Matches as a tournament or a league left them, read without knowing who played: for pictures and pages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.tournament import MEDIAN, Figures, Meeting, Table
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.reading import read_json

PARTS = 3  # of a match's file name: scenario, red, blue


def read_matches(folder: Path) -> Table:
    """All matches of a folder, checked for what is shown of them.

    Raises:
        FileFormatError: a file is broken, or its name is no match's.
    """
    rows = {}
    for path in sorted(folder.glob("*.json")):
        parts = path.stem.split("~")
        if len(parts) != PARTS or not all(parts):
            raise FileFormatError(path, "name", found=path.stem, expected="SCENARIO~RED~BLUE")
        scenario, red, blue = parts
        rows[Meeting(red=red, blue=blue, scenario=scenario)] = _row(path)
    return Table(rows)


def _row(path: Path) -> dict[str, Any]:
    row = read_json(path, "a match")
    found = {camp: _figures(row.get(camp), path, camp) for camp in ("red", "blue")}
    for name, least in ((MEDIAN, 0), ("seed", 0)):
        if name in row and not (type(row[name]) is int and row[name] >= least):
            raise FileFormatError(path, name, found=repr(row[name]), expected="a whole number")
    if MEDIAN in row and "seed" not in row:
        raise FileFormatError(path, "seed", found="nothing", expected="a whole number")
    return {**{name: row[name] for name in (MEDIAN, "seed") if name in row}, **found}


def _figures(values: object, path: Path, camp: str) -> dict[str, Any]:
    figures = Figures(**read_fields(Figures, values, path, place=camp, whole=True))
    rate = wilson(figures.wins + figures.draws / 2, max(1, figures.games))
    found = (figures.win_rate, *figures.win_rate_interval)
    if (
        figures.wins + figures.draws + figures.losses != figures.games
        or min(figures.wins, figures.draws, figures.losses) < 0
    ):
        counts = (figures.wins, figures.draws, figures.losses)
        raise FileFormatError(
            path, f"{camp}.games", found=f"{figures.games}", expected=f"the sum of {counts}"
        )
    if max(abs(a - b) for a, b in zip(found, (rate.value, rate.low, rate.high), strict=True)) > 1e-9:
        raise FileFormatError(
            path, f"{camp}.win_rate", found=str(figures.win_rate), expected=f"{rate.value}, by its games"
        )
    return {
        "games": figures.games,
        "wins": figures.wins,
        "draws": figures.draws,
        "win_rate": figures.win_rate,
        "win_rate_interval": figures.win_rate_interval,
    }


def table_of_rates(rates: Mapping[str, float], scenario: str, games: int) -> Table:
    """A table of red's win rates by "RED BLUE", as a league's `table.json` keeps them, each of so many games."""
    rows = {}
    for names, rate in rates.items():
        red, _, blue = names.partition(" ")
        found = wilson(rate * games, games)
        row = {"games": games, "wins": rate * games, "draws": 0, "win_rate": rate}
        other = {**row, "wins": (1 - rate) * games, "win_rate": 1 - rate}
        interval, opposite = (found.low, found.high), (1 - found.high, 1 - found.low)
        rows[Meeting(red=red, blue=blue, scenario=scenario)] = {
            "red": {**row, "win_rate_interval": interval},
            "blue": {**other, "win_rate_interval": opposite},
        }
    return Table(rows)
