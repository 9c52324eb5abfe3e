"""Fig. 7: learning curves of the hierarchy (HRL) and of its rivals, against MA1 and MA2, on three maps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.curve import band
from hexwar_sb3.experiments.kept import Kept
from hexwar_sb3.experiments.runs import (
    FLAT_DQN,
    RIVAL_DQN,
    TASK_PPO,
    Budget,
    Places,
    Run,
    baseline_run,
    hrl_run,
)
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.files import load_scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAME, GAMES, FINAL_GAMES = "fig7", 10_000, 2_000
SEEDS = (0, 1, 2)
SCENARIOS = ("plain", "hills", "paddy")  # the first with all seeds, the others with the first seed
METHODS = {"hrl": "HRL", "rival": "DQN, HRL's means", "dqn": "DQN, the paper's", "ppo": "MaskablePPO"}
RIVALS = {"rival": RIVAL_DQN, "dqn": FLAT_DQN, "ppo": TASK_PPO}
QUANTITIES = (("win_rate", "win rate"), ("mean_margin", "mean margin, points"))


def runs(budget: Budget, seeds: Sequence[int]) -> list[Run]:
    """Every run of the figure."""
    return [
        run
        for scenario in SCENARIOS
        for seed in (seeds if scenario == SCENARIOS[0] else seeds[:1])
        for run in (hierarchy(scenario, seed, budget), *rivals(scenario, seed, budget))
    ]


def hierarchy(scenario: str, seed: int, budget: Budget) -> Run:
    """Both levels, against the bots."""
    return hrl_run(NAME, f"hrl-{scenario}", seed, budget, "--opponents", *BOTS, scenario=scenario)


def rivals(scenario: str, seed: int, budget: Budget) -> list[Run]:
    """The others on equal terms: the same opponents, and as many game ticks as all levels have together."""
    game = load_scenario(scenario).game_ticks
    games = budget.games + math.ceil(PRESETS["default"].lower_ticks(budget.games * game) / game)
    return [
        baseline_run(module, NAME, f"{name}-{scenario}", seed, budget, games=games, scenario=scenario)
        for name, module in RIVALS.items()
    ]


def draw(all_runs: Sequence[Run], places: Places, path: Path) -> None:
    """Draw the figure from the results that are there.

    Args:
        all_runs: of the figure.
        places: of their results.
        path: picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    there = [run for run in all_runs if places.is_kept(run)]
    scenarios = [name for name in SCENARIOS if any(run.row.endswith(f"-{name}") for run in there)]
    figure = Figure(figsize=(16, 3.6 * max(1, len(scenarios))), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(max(1, len(scenarios)), 4, squeeze=False)
    columns = [(opponent, *quantity) for opponent in BOTS for quantity in QUANTITIES]
    for i, scenario in enumerate(scenarios):
        game_ticks = load_scenario(scenario).game_ticks
        for axes, (opponent, quantity, label) in zip(grid[i], columns, strict=True):
            for method in METHODS:
                kept = [places.kept(run) for run in there if run.row == f"{method}-{scenario}"]
                _draw_method(axes, method, kept, opponent, quantity, game_ticks)
            _dress(axes, f"{scenario}, against {opponent}", label)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100)


def _draw_method(
    axes: Axes, method: str, kept: list[Kept], opponent: str, quantity: str, game_ticks: int
) -> None:
    """Draw the mean over seeds; the band reaches from the lowest to the highest seed, or is a single seed's interval.

    Both levels' game time counts, in games of the length of the scenario's.
    """
    if not kept:
        return
    mean = band([one.curve(opponent) for one in kept], quantity)
    games, color = mean.ticks / game_ticks, f"C{list(METHODS).index(method)}"
    axes.plot(games, mean.mean, color=color, marker="o", markersize=3, label=_label(method, kept))
    axes.fill_between(games, mean.low, mean.high, color=color, alpha=0.25, linewidth=0)


def _label(method: str, kept: list[Kept]) -> str:
    minutes = fmean(one.minutes for one in kept)
    return f"{METHODS[method]}, {len(kept)} seed{'s' * (len(kept) > 1)}, {minutes:.0f} min each"


def _dress(axes: Axes, title: str, label: str) -> None:
    axes.set_title(title)
    axes.set_xlabel("episodes, of both levels")
    axes.set_ylabel(label)
    axes.grid(alpha=0.3)
    if label == QUANTITIES[0][1]:
        axes.set_ylim(0, 1)
    else:
        axes.axhline(0, color="grey", linewidth=0.8)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize="small", framealpha=0.6)
