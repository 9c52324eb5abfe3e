"""`curves.csv`: the learning curves of the runs of an experiment, against each opponent and against all."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.csv_file import number_in, read_rows
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.files import replacing

ALL = "all"  # opponents, joined
RUN = "run"  # head of the column of its name
HEADS = (
    *("env_steps", "games", "game_ticks", "opponent"),
    *("win_rate", "win_rate_low", "win_rate_high"),
    *("mean_margin", "mean_margin_low", "mean_margin_high", "points_held"),
)


def by_opponent(result: CampResult, opponents: Sequence[str]) -> dict[str, CampResult]:
    """Take the joined games of a panel apart: they lie opponent by opponent, as many games each.

    Raises:
        ConfigError: so many opponents cannot have had as many games each.
    """
    if not opponents or result.games % len(opponents):
        raise ConfigError(f"{result.games} games are not as many each against {len(opponents)} opponents")
    columns = (result.scores, result.margins, result.points_held)
    parts = zip(*(np.split(column, len(opponents)) for column in columns), strict=True)
    return {name: CampResult(*part) for name, part in zip(opponents, parts, strict=True)}


def curve_rows(
    history: History, opponents: Sequence[str], *, decision_ticks: int | None, game_ticks: int
) -> Iterator[dict[str, Any]]:
    """One row an evaluation and opponent. Games are those of the upper level, game ticks those of all levels.

    Args:
        history: of the run.
        opponents: that it was evaluated against, in this order.
        decision_ticks: ticks of an env step; None where they vary, then games stay empty.
        game_ticks: ticks of a game.
    """
    for steps, ticks, result in zip(history.timesteps, history.game_ticks, history.results, strict=True):
        games = None if decision_ticks is None else steps * decision_ticks // game_ticks
        for name, part in {ALL: result, **by_opponent(result, opponents)}.items():
            rate, margin = part.win_rate, part.mean_margin
            figures = (rate.value, rate.low, rate.high, margin.value, margin.low, margin.high)
            row = (steps, games, ticks, name, *figures, float(part.points_held.mean()))
            yield dict(zip(HEADS, row, strict=True))


def write_curve(path: Path, run: str, rows: Iterable[Mapping[str, Any]]) -> None:
    """Put the curve of a run into the table; its rows of before go.

    Raises:
        FileFormatError: the table is broken.
    """
    others = [row for row in (read_rows(path) if path.exists() else []) if row.get(RUN) != run]
    own = [{RUN: run, **{key: _written(value) for key, value in row.items()}} for row in rows]
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, (RUN, *HEADS), extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted([*others, *own], key=lambda row: row[RUN] or ""))


def _written(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value


def read_curve(path: Path, run: str, opponent: str) -> dict[str, list[float]]:
    """Columns of a run's curve against one opponent.

    Raises:
        FileFormatError: the table is broken, or has no row of this run and opponent.
    """
    rows = [row for row in read_rows(path) if (row.get(RUN), row.get("opponent")) == (run, opponent)]
    if not rows:
        raise FileFormatError(path, run, found="no row", expected=f"rows against {opponent!r}")
    numbers = [head for head in HEADS if head != "opponent"]
    return {head: [number_in(row, head, path) for row in rows] for head in numbers}


@dataclass(frozen=True, eq=False)
class Band:
    """A quantity over the game time of all levels, over seeds; a row an evaluation."""

    ticks: NDArray[np.float64]
    mean: NDArray[np.float64]
    low: NDArray[np.float64]  # of the lowest seed; of a single one, the end of its 95 % interval
    high: NDArray[np.float64]


def band(curves: Sequence[Mapping[str, list[float]]], quantity: str) -> Band:
    """The curves of one or more seeds, as `read_curve` gives them, at the ticks of the first one."""
    ticks = np.array(curves[0]["game_ticks"])
    values = np.array([np.interp(ticks, curve["game_ticks"], curve[quantity]) for curve in curves])
    low, high = values.min(axis=0), values.max(axis=0)
    if len(curves) == 1:
        low, high = (np.array(curves[0][f"{quantity}_{end}"]) for end in ("low", "high"))
    return Band(ticks, values.mean(axis=0), low, high)
