"""What the cover of a page of many games shows beside its games: a learning curve, the tables of a round robin."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.evaluation.tournament import MEDIAN, Meeting, Table
from hexwar_sb3.viewer.story import NAME_CHARACTERS
from hexwar_sb3.viewer.tracks import Json

_DIGITS = 4
NO_GAME = 0  # games of a page are numbered from 1


def curve_part(history: History, games: Mapping[int, int]) -> Json:
    """The learning curve of a training.

    Args:
        history: its evaluations.
        games: number of the game on the page by env steps, where there is one.
    """
    rows = [
        [steps, games.get(steps, NO_GAME), _told(result.win_rate), _told(result.mean_margin)]
        for steps, result in zip(history.timesteps, history.results, strict=True)
    ]
    return {"games": history.results[0].games if rows else 0, "rows": rows}


def table_part(table: Table, scenario: str, games: Mapping[str, int], name: str = "") -> Json:
    """The heat map of a map: red players by rows, blue ones by columns, the best first.

    Args:
        table: of the round robin.
        scenario: the map.
        games: number of a recorded game on the page, by the stem of its match.
        name: of the table; else the map's.
    """
    there = {meeting: row for meeting, row in table.rows.items() if meeting.scenario == scenario}
    own = Table(there)
    reds, blues = (
        sorted(
            dict.fromkeys(getattr(meeting, camp) for meeting in there),
            key=lambda name: (-own.win_rate(name, "red", "blue").value, name),
        )
        for camp in ("red", "blue")
    )
    cells = [
        [_cell(Meeting(red=red, blue=blue, scenario=scenario), there, games) for blue in blues]
        for red in reds
    ]
    return {
        "name": (name or Path(scenario).name)[:NAME_CHARACTERS],
        "red": [red[:NAME_CHARACTERS] for red in reds],
        "blue": [blue[:NAME_CHARACTERS] for blue in blues],
        "cells": cells,
    }


def _cell(
    meeting: Meeting, rows: Mapping[Meeting, Mapping[str, Any]], games: Mapping[str, int]
) -> Json | None:
    """Of a match: red's win rate, how many games, and which of them is on the page."""
    row = rows.get(meeting)
    if row is None:
        return None
    red = row["red"]
    told = {"rate": _told(Estimate(red["win_rate"], *red["win_rate_interval"])), "games": red["games"]}
    game = games.get(meeting.stem, NO_GAME)
    if game == NO_GAME or MEDIAN not in row:
        return told
    return {**told, "game": game, "episode": row[MEDIAN], "seed": row["seed"]}


def _told(estimate: Estimate) -> list[float]:
    return [round(value, _DIGITS) for value in (estimate.value, estimate.low, estimate.high)]
