"""`hexwar bench`: speed on this machine, one core, full rules, seven pieces a side."""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.checks import check_whole
from hexwar_sb3.commands.output import print_json, table
from hexwar_sb3.commands.settings import Json, ScenarioName


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure the engine, the bots, the env and the learner: process time, best of several rounds."""

    scenario: ScenarioName = "plain"
    rounds: int = 5  # the best one counts
    json: Json = False

    def run(self) -> int:
        """Print the figures."""
        check_whole("rounds", self.rounds, least=1)
        from hexwar_sb3.commands.bench_games import game_figures
        from hexwar_sb3.commands.bench_learner import learner_figures
        from hexwar_sb3.commands.bench_start import start_figures
        from hexwar_sb3.league.cost import peak_mb

        figures = {
            **game_figures(self.scenario, self.rounds),
            **learner_figures(self.scenario, self.rounds),
            **start_figures(),
            "peak_mb": peak_mb(),
        }
        if self.json:
            print_json(figures)
        else:
            print(table(("figure", "value"), [[name, _text(value)] for name, value in figures.items()]))
        return 0


def _text(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.2f}"
