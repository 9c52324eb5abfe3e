"""`hexwar bench`: speed on this machine, one core, full rules."""

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
    sizes: bool = False  # instead: what more pieces and larger maps cost
    json: Json = False

    def run(self) -> int:
        """Print the figures."""
        check_whole("rounds", self.rounds, least=1)
        if self.sizes:
            return self._run_sizes()
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

    def _run_sizes(self) -> int:
        from hexwar_sb3.commands.bench_sizes import HEADS, exponents, size_figures

        rows = size_figures(self.rounds)
        powers = exponents(rows)
        if self.json:
            print_json({"rows": rows, "exponents": powers})
            return 0
        print(table(tuple(HEADS.values()), [[_text(row[name]) for name in HEADS] for row in rows]))
        print("\nexponents from row to row")
        for name, each in powers.items():
            print(f"{name}: {', '.join(f'{one:.2f}' for one in each)}")
        return 0


def _text(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.2f}"
