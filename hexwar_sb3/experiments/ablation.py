"""The ablation: rows that differ from a base in one thing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import isnan
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.evaluation.opponents import OPPONENTS
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.kept import RUNS, Kept, PageRow
from hexwar_sb3.experiments.runs import (
    FLAT_DQN,
    NO_PLANS,
    TASK_PPO,
    Budget,
    Places,
    Run,
    baseline_run,
    hrl_run,
)
from hexwar_sb3.experiments.spread import seed_difference, spread

NAME, BASE = "ablation", "base"
SEEDS = (0, 1, 2)
GAMES = 5_000  # fewer than a whole training has: what slows learning shows, and so do more seeds
FINAL_GAMES = 700  # three seeds have 2,100 a cell
QUANTITIES = ("win_rate", "mean_margin", "points_held")
HEADS = ("row", "against", "seeds", "win rate, %", "mean margin", "points held", "margin minus base")


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the table."""

    says: str  # how it differs from the base
    lower: str = "heuristic"
    flags: tuple[str, ...] = ()
    opponents: tuple[str, ...] = BOTS


ROWS = {
    BASE: Row(says="defaults against MA1 and MA2, with the heuristic as the lower level"),
    "learned-lower": Row(says="the lower level is learned too", lower="learned"),
    "vdn": Row(says="values added, no mixer", flags=("--mixer", "vdn")),
    "iql": Row(says="each piece learns alone", flags=("--mixer", "iql")),
    "warm-start": Row(says="games begin near G^B", flags=("--warm-start", "1.0")),
    "no-demos": Row(says="no bot shows how it plays", flags=("--demo-share", "0.0")),
    "one-step": Row(says="one-step returns", flags=("--n-steps", "1")),
    "plain-epsilon": Row(says="random tasks are not kept", flags=("--stickiness", "0.0")),
    "no-squads": Row(
        says="no squad explores as one", flags=("--squad-initial-share", "0.0", "--squad-final-share", "0.0")
    ),
    "seen-camp": Row(says="networks see which camp they play", flags=("--mirrored", "False")),
    "narrow": Row(says="64 hidden units", flags=("--hidden", "64")),
    "broad": Row(says="learns against the broad mixture", opponents=OPPONENTS),
    "broad-even": Row(
        says="learns against the broad mixture without priorities",
        opponents=OPPONENTS,
        flags=("--priority", "0.0"),
    ),
    "only-ma1": Row(says="learns against MA1 alone", opponents=("MA1",)),
    "gamma-1": Row(says="no discount, eq. (4)", flags=("--gamma", "1.0")),
    "paper-reward": Row(says="margin by eq. (1), Green counts", flags=("--reward", "paper")),
    "lambda-08": Row(says="lambda-returns", flags=("--td-lambda", "0.8")),
    "single-q": Row(says="no double-Q", flags=("--double-q", "False")),
    "paper-preset": Row(says="section IV to the letter, over the heuristic", flags=("--preset", "paper")),
}
BASELINES = {
    "flat-dqn": (FLAT_DQN, "no hierarchy: Stable-Baselines3's DQN on the flat env, as many games"),
    "maskable-ppo": (TASK_PPO, "sb3-contrib's MaskablePPO on the task env, as many games"),
}
SAYS = {
    **{name: row.says for name, row in ROWS.items()},
    **{name: says for name, (_, says) in BASELINES.items()},
}


def runs(budget: Budget, seeds: Sequence[int]) -> list[Run]:
    """Every run of the table, seed by seed, so that one seed of every row comes first; figures only, no policies."""
    return [replace(run, with_policy=False) for seed in seeds for run in _runs_of(seed, budget)]


def _runs_of(seed: int, budget: Budget) -> Iterator[Run]:
    for name in ROWS:
        yield row_run(name, seed, budget)
    for name, (module, _) in BASELINES.items():
        yield baseline_run(module, NAME, name, seed, budget, NO_PLANS)


def row_run(name: str, seed: int, budget: Budget) -> Run:
    """A run of a row of our own."""
    row = ROWS[name]
    constant = () if name == BASE else (NO_PLANS,)
    flags = ("--lower", row.lower, *constant, *row.flags, "--opponents", *row.opponents)
    return hrl_run(NAME, name, seed, budget, *flags)


def summary(all_runs: Sequence[Run], places: Places) -> list[dict[str, Any]]:
    """One JSON object a row; `against` is empty where no run of the row is there."""
    there: dict[str, list[Run]] = {run.row: [] for run in all_runs}
    for run in all_runs:
        if places.is_kept(run):
            there[run.row].append(run)
    figures = {row: [figures_of(places.kept(run)) for run in kept] for row, kept in there.items()}
    return [
        {
            "row": row,
            "says": SAYS[row],
            "seeds": [run.seed for run in there[row]],
            "commands": [run.command for run in there[row]],
            "against": {
                opponent: _against(opponent, figures[row], figures.get(BASE, []))
                for opponent in BOTS
                if there[row]
            },
        }
        for row in there
    ]


def figures_of(kept: Kept) -> dict[tuple[str, str], float]:
    """Figures of the trained player on a page by (opponent, quantity); both colours together."""
    rows, figures = kept.rows(), {}
    for opponent in BOTS:
        cells = [row for row in rows if (row.player, row.opponent) == ("trained", opponent)]
        if not cells:
            found, expected = "no row", f"rows of the trained player against {opponent}"
            raise FileFormatError(
                kept.folder / RUNS, f"{kept.name}.page.rows", found=found, expected=expected
            )
        for quantity in QUANTITIES:
            figures[opponent, quantity] = sum(_value(cell, quantity) for cell in cells) / len(cells)
    return figures


def _value(cell: PageRow, quantity: str) -> float:
    return cell.mean_points if quantity == "points_held" else float(getattr(cell, quantity))


def _against(
    opponent: str, ours: list[dict[tuple[str, str], float]], base: list[dict[tuple[str, str], float]]
) -> dict[str, list[float | None]]:
    values = {quantity: [seed[opponent, quantity] for seed in ours] for quantity in QUANTITIES}
    minus = seed_difference(values["mean_margin"], [seed[opponent, "mean_margin"] for seed in base])
    return {
        **{quantity: _numbers(spread(values[quantity])) for quantity in QUANTITIES},
        "margin_minus_base": _numbers(minus),
    }


def _numbers(estimate: Estimate) -> list[float | None]:
    return [None if isnan(value) else value for value in (estimate.value, estimate.low, estimate.high)]


def cells(rows: Sequence[dict[str, Any]]) -> Iterator[list[str]]:
    """Cells of the text table, one line a row and opponent; one that is missing says so."""
    for row in rows:
        if not row["against"]:
            yield [row["row"], "-", "0", "missing", "", "", ""]
        for opponent, figures in row["against"].items():
            rate = [100 * value for value in figures["win_rate"]]
            base = row["row"] == BASE
            yield [
                *(row["row"], opponent, str(len(row["seeds"]))),
                _text(rate, ".1f"),
                _text(figures["mean_margin"], "+.1f"),
                _text(figures["points_held"], ".2f"),
                "" if base else _text(figures["margin_minus_base"], "+.1f"),
            ]


def _text(numbers: Sequence[float | None], how: str) -> str:
    """A figure and its ends; a dash for what is not known."""
    value, low, high = ("-" if number is None else format(number, how) for number in numbers)
    return f"{value} [{low}, {high}]"
