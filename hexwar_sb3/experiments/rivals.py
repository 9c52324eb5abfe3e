"""A search over the settings of the rivals of Fig. 7, the flat DQN and MaskablePPO: as many short trainings of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from statistics import fmean
from typing import Any

import numpy as np

from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.runs import NO_PLANS, RIVAL_DQN, TASK_PPO, Budget, Places, Run, baseline_run

NAME, GAMES, FINAL_GAMES = "rivals", 2_000, 200
SEEDS = (0,)
SETTINGS = 20  # of each rival
HEADS = ("run", "win rate, %", "mean margin", "points held", "settings")
Space = Mapping[str, tuple[tuple[str, ...], ...]]

BOTH: Space = {
    "--learning-rate": (("1e-4",), ("3e-4",), ("1e-3",)),
    "--net-arch": (("64", "64"), ("128", "128"), ("256", "128")),
    "--batch-size": (("64",), ("128",)),
    "--reward": (("net",), ("paper",)),
    "--gamma": (("0.99",), ("0.95",)),
}
DQN_SPACE: Space = {
    **BOTH,
    "--n-steps": (("1",), ("7",), ("28",), ("84",)),  # turns: up to twelve decisions
    "--target-update-turns": (("3200",), ("16000",)),
    "--stickiness": (("0.0",), ("0.8",)),
    "--exploration-final-eps": (("0.005",), ("0.05",)),
    "--demo-share": (("0.0",), ("0.25",), ("0.5",)),
    "--demo-games": (("500",), ("2000",)),
}
PPO_SPACE: Space = {
    **BOTH,
    "--n-steps": (("24",), ("96",), ("192",)),  # decisions of each game: one game, four, eight
    "--n-epochs": (("4",), ("10",)),
    "--ent-coef": (("0.0",), ("0.003",), ("0.01",)),
    "--gae-lambda": (("0.8",), ("0.95",)),
}
RIVALS = {"dqn": (RIVAL_DQN, DQN_SPACE), "ppo": (TASK_PPO, PPO_SPACE)}


def runs(budget: Budget, seeds: Sequence[int]) -> list[Run]:
    """Every run; the first setting of a rival is its default."""
    found = [
        baseline_run(module, NAME, f"{rival}-{k:02d}", seed, budget, NO_PLANS, *flags)
        for rival, (module, space) in RIVALS.items()
        for k, flags in enumerate(settings(space))
        for seed in seeds
    ]
    return [replace(run, with_policy=False) for run in found]


def settings(space: Space) -> list[tuple[str, ...]]:
    """Flags of SETTINGS trainings: none, then random ones, the same at every call."""
    rng = np.random.default_rng(0)
    drawn = [
        tuple(
            word
            for flag, choices in space.items()
            for word in (flag, *choices[int(rng.integers(len(choices)))])
        )
        for _ in range(1, SETTINGS)
    ]
    return [(), *drawn]


def summary(all_runs: Sequence[Run], places: Places) -> list[dict[str, Any]]:
    """One JSON object a run, those of a rival from the best mean margin down."""
    rows = [_row(run, places) for run in all_runs if places.is_kept(run)]
    return sorted(rows, key=lambda row: (row["rival"], -row["mean_margin"]))


def _row(run: Run, places: Places) -> dict[str, Any]:
    own = [row for row in places.kept(run).rows() if row.player == "trained" and row.opponent in BOTS]
    return {
        "rival": run.row.partition("-")[0],
        "run": run.name,
        "command": run.command,
        "win_rate": fmean(row.win_rate for row in own),
        "mean_margin": fmean(row.mean_margin for row in own),
        "points_held": fmean(row.mean_points for row in own),
        "settings": _flags(run),
    }


def _flags(run: Run) -> str:
    words = run.arguments
    return " ".join(words[words.index(NO_PLANS) + 1 :]).replace("--", "") or "the default"


def cells(rows: Sequence[dict[str, Any]]) -> Iterator[list[str]]:
    """Cells of the text table."""
    for row in rows:
        yield [
            row["run"],
            f"{100 * row['win_rate']:.1f}",
            f"{row['mean_margin']:+.0f}",
            f"{row['points_held']:.2f}",
            row["settings"],
        ]
