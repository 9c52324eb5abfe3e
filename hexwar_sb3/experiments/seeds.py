"""How much luck a training needs: the same command with many seeds, and what the worst of them reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from statistics import fmean, stdev
from typing import Any

from hexwar_sb3.evaluation.matches import CAMPS
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.fig7 import hierarchy
from hexwar_sb3.experiments.kept import PageRow
from hexwar_sb3.experiments.runs import NO_PLANS, Budget, Places, Run, hrl_run

NAME, GAMES, FINAL_GAMES = "seeds", 10_000, 2_000
SEEDS = tuple(range(8))
CANDIDATES: dict[str, tuple[str, ...]] = {"single-q": ("--double-q", "False")}
"""Settings that are compared with the default on "plain", with all seeds: flags of `hexwar train`."""
NAMES = {"hrl-plain": "only MA1 and MA2"}  # the paper's warm-up, runs of figure 7
OTHER_MAPS = ("hills", "paddy")  # the default, with the first seeds
SEEDS_THERE = 3
TRAINED, ALL = "trained", "mean of MA1 and MA2"
HEADS = ("training", "seeds", "against", "camp", "win rate, %", "worst", "sd", "margin", "points held")


def default_run(scenario: str, seed: int, budget: Budget) -> Run:
    """A run of `hexwar train` as it is, without the constant plans, which are the same for all."""
    return hrl_run(
        NAME, "default" if scenario == "plain" else scenario, seed, budget, NO_PLANS, scenario=scenario
    )


def runs(budget: Budget, seeds: Sequence[int]) -> list[Run]:
    """Every run, seed by seed."""
    found = [
        run
        for seed in seeds
        for run in (
            default_run("plain", seed, budget),
            *(hrl_run(NAME, name, seed, budget, NO_PLANS, *flags) for name, flags in CANDIDATES.items()),
            hierarchy("plain", seed, budget),
        )
    ]
    found += [default_run(scenario, seed, budget) for seed in seeds[:SEEDS_THERE] for scenario in OTHER_MAPS]
    return [replace(run, with_policy=run.row != "single-q") for run in found]


def summary(
    all_runs: Sequence[Run], places: Places, names: Mapping[str, str] = NAMES
) -> list[dict[str, Any]]:
    """One JSON object a training, opponent and camp: win rates by seed, their mean, worst and standard deviation.

    Args:
        all_runs: of the table.
        places: of their results.
        names: what trainings are called, where not as their row.
    """
    rows: list[dict[str, Any]] = []
    for name in dict.fromkeys(run.row for run in all_runs):
        there = [run for run in all_runs if run.row == name and places.is_kept(run)]
        pages = [
            [row for row in places.kept(run).rows(others=True) if row.player == TRAINED] for run in there
        ]
        about = (
            {
                "training": names.get(name, name),
                "seeds": [run.seed for run in there],
                "command": there[0].command,
            }
            if there
            else {}
        )
        rows += [{**about, **row} for row in _cells(pages)]
    return rows


def _cells(pages: Sequence[Sequence[PageRow]]) -> Iterator[dict[str, Any]]:
    if not pages:
        return
    cells = [{(row.opponent, row.camp): row for row in page} for page in pages]
    known = [(bot, camp) for bot in BOTS for camp in CAMPS]
    yield {
        "against": ALL,
        "camp": "both",
        **_spread([fmean(page[cell].win_rate for cell in known) for page in cells]),
    }
    for opponent, camp in cells[0]:
        own = [page[opponent, camp] for page in cells]
        yield {
            "against": opponent,
            "camp": camp,
            **_spread([row.win_rate for row in own]),
            "mean_margin": fmean(row.mean_margin for row in own),
            "points_held": fmean(row.mean_points for row in own),
        }


def _spread(rates: Sequence[float]) -> dict[str, Any]:
    return {
        "win_rates": list(rates),
        "mean": fmean(rates),
        "worst": min(rates),
        "sd": stdev(rates) if len(rates) > 1 else None,
    }


def cells(rows: Sequence[dict[str, Any]]) -> Iterator[list[str]]:
    """Cells of the text table."""
    for row in rows:
        yield [
            row["training"],
            str(len(row["seeds"])),
            row["against"],
            row["camp"],
            *("-" if row[name] is None else f"{100 * row[name]:.1f}" for name in ("mean", "worst", "sd")),
            f"{row['mean_margin']:+.0f}" if "mean_margin" in row else "",
            f"{row['points_held']:.2f}" if "points_held" in row else "",
        ]
