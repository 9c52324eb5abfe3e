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
from hexwar_sb3.maps.files import load_scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

NAME, GAMES, FINAL_GAMES = "fig7", 10_000, 2_000
SEEDS = (0, 1, 2)
SCENARIOS = ("plain", "hills", "paddy")  # the first with all seeds, the others with the first seed
METHODS = {"hrl": "HRL", "rival": "DQN, HRL's means", "dqn": "DQN, the paper's", "ppo": "MaskablePPO"}
RIVALS = {"rival": RIVAL_DQN, "dqn": FLAT_DQN, "ppo": TASK_PPO}
PAPERS = "the paper's HRL0"
QUANTITIES = (("win_rate", "win rate"), ("mean_margin", "mean margin, points"))
PAPER = {"MA1": 0.935, "MA2": 0.88}  # win rates of the paper's HRL0, mean of both colours (Tab. I)


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
    from matplotlib.ticker import EngFormatter

    from hexwar_sb3.pictures import FAINT, INK, new_figure, write_figure

    there = [run for run in all_runs if places.is_kept(run)]
    scenarios = [name for name in SCENARIOS if any(run.row.endswith(f"-{name}") for run in there)]
    rows = max(1, len(scenarios))
    figure = new_figure(14, 1.2 + 3.0 * rows)
    grid = figure.subplots(rows, 4, squeeze=False, sharex=True)
    lines: dict[str, Line2D] = {}
    for i, scenario in enumerate(scenarios):
        for j, (quantity, label) in enumerate(QUANTITIES):
            panels = grid[i, 2 * j : 2 * j + 2]
            panels[1].sharey(panels[0])
            for axes, opponent in zip(panels, BOTS, strict=True):
                for method in METHODS:
                    kept = [places.kept(run) for run in there if run.row == f"{method}-{scenario}"]
                    if kept:
                        _draw_method(
                            axes, method, kept, opponent, quantity, load_scenario(scenario).game_ticks
                        )
                _dress(axes, f"{scenario}, against {opponent}", label)
                if scenario == SCENARIOS[0] and label == QUANTITIES[0][1]:  # Tab. I is of the first map
                    axes.axhline(PAPER[opponent], color=FAINT, linewidth=1.2, linestyle="--", label=PAPERS)
                lines |= {str(line.get_label()): line for line in axes.get_lines()}
    for axes in grid[-1]:
        axes.set_xlabel("episodes, of both levels")
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))  # 10k
    words = [name for name in (*METHODS.values(), PAPERS) if name in lines]
    band_says = "band: lowest to highest seed; of one seed its 95 % interval"
    figure.legend(
        [lines[name] for name in words],
        [name if name == PAPERS else f"{name} ({_effort(name, there, places)})" for name in words],
        title=band_says, loc="outside upper center", ncols=len(words) or 1, frameon=False, labelcolor=INK,
    )  # fmt: skip
    write_figure(figure, path)


def _draw_method(
    axes: Axes, method: str, kept: list[Kept], opponent: str, quantity: str, game_ticks: int
) -> None:
    """Draw the mean over seeds; the band reaches from the lowest to the highest seed, or is a single seed's interval.

    Both levels' game time counts, in games of the length of the scenario's.
    """
    from hexwar_sb3.pictures import colour, draw_band

    mean = band([one.curve(opponent) for one in kept], quantity)
    line = colour(list(METHODS).index(method))
    draw_band(
        axes, mean.ticks / game_ticks, mean.mean, mean.low, mean.high, color=line, label=METHODS[method]
    )


def _effort(name: str, there: Sequence[Run], places: Places) -> str:
    """Trainings of a method, and what one took."""
    (method,) = (key for key, words in METHODS.items() if words == name)
    kept = [places.kept(run) for run in there if run.row.startswith(f"{method}-")]
    minutes = fmean(one.minutes for one in kept)
    return f"{len(kept)} training{'s' * (len(kept) > 1)}, {minutes:.0f} min each"


def _dress(axes: Axes, title: str, label: str) -> None:
    from hexwar_sb3.pictures import INK, dress

    dress(axes, title, ylabel=label)
    if label == QUANTITIES[0][1]:
        axes.set_ylim(0, 1)
    else:
        axes.axhline(0, color=INK, linewidth=0.6)
