"""`hexwar experiments`: the runs behind a figure or a table, made where their results are missing."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from hexwar_sb3.commands.output import as_json, compile_first, print_json, table
from hexwar_sb3.commands.run_folder import write_text
from hexwar_sb3.commands.settings import Cluster, Json, check_jobs
from hexwar_sb3.errors import ConfigError, UnknownNameError

if TYPE_CHECKING:
    from hexwar_sb3.experiments.runs import Places, Run, State

NAMES = ("fig7", "ablation", "seeds", "rivals")
TABLE1 = "table1"  # one pipeline instead of runs
FAILED, INTERRUPTED = 1, 130  # exit codes


@dataclass(frozen=True, kw_only=True)
class Experiments:
    """Make the runs of an experiment whose results are missing, then its figure or table; go on by the same command."""

    # "fig7": HRL against its rivals; "ablation": rows that differ in one thing; "seeds": what luck does to a training;
    # "rivals": settings of the flat DQN and of MaskablePPO; "table1": self-play and distillation
    name: tyro.conf.Positional[str]
    list: bool = False  # print what is there and what is missing, and do nothing
    only: tuple[str, ...] = ()  # runs ("vdn-0") or rows ("vdn": all its seeds); else all
    # of every row, else 0 1 2; 0 to 7 for "seeds", where other maps have the first of them; 0 for "rivals"
    seeds: tuple[int, ...] = ()
    games: int | None = None  # of a run; else 10,000; 5,000 for the ablation, and 2,000 for "rivals"
    eval_games: int = 64  # an opponent and colour, at each of the ten points of a curve
    final_games: int | None = None  # an opponent and colour, on the page of a run; else 2,000, 700 and 200
    jobs: int | None = None  # runs side by side; else 1, or the cluster's processors
    cluster: Cluster = None
    results: Path = Path("results")  # small files that are kept: RESULTS/EXPERIMENT/
    work: Path = Path("runs/experiments")  # run folders
    json: Json = False

    def run(self) -> int:
        """List, or carry out and draw."""
        from hexwar_sb3.evaluation.cluster import working_on
        from hexwar_sb3.experiments.carry_out import carry_out
        from hexwar_sb3.experiments.runs import Places, State, choose

        if self.name == TABLE1:
            return self._table1()
        runs, places = self._runs(), Places(self.results, self.work)
        chosen = choose(runs, self.only)
        states = {run: places.state(run) for run in runs}
        if self.list:
            self._print_states({run: states[run] for run in chosen}, places)
            return 0
        if any(states[run] != State.DONE for run in chosen):
            compile_first()
        try:
            with working_on(self.cluster, self.jobs) as jobs:
                failed = carry_out(chosen, places, jobs=jobs, say=_say)
        except KeyboardInterrupt:
            _say("stopped; the same command goes on")
            return INTERRUPTED
        for path in finish(self.name, runs, places):
            _say(str(path))
        return FAILED if failed else 0

    def _table1(self) -> int:
        """Carry out the pipeline, then write the table.

        Raises:
            ConfigError: a flag of the other experiments was given.
        """
        from hexwar_sb3.evaluation.cluster import working_on
        from hexwar_sb3.experiments.runs import Places
        from hexwar_sb3.experiments.table1 import Table1
        from hexwar_sb3.experiments.table1_page import write

        check_jobs("jobs", self.jobs)
        for flag in ("only", "seeds", "games", "eval_games", "final_games"):
            if getattr(self, flag) != getattr(Experiments, flag):
                raise ConfigError(f"table1 is one pipeline with settings of its own; it takes no {flag}")
        pipeline = Table1(places=Places(self.results, self.work))
        if self.list:
            states = pipeline.states()
            text = table(("stage", "state"), [[stage, state] for stage, state in states.items()])
            print_json({"stages": states}) if self.json else print(text)
            return 0
        compile_first()
        try:
            with working_on(self.cluster, self.jobs) as jobs:
                found = replace(pipeline, jobs=jobs).run(_say)
        except KeyboardInterrupt:
            _say("stopped; the same command goes on")
            return INTERRUPTED
        if found is None:
            return FAILED
        figures, text = write(found, pipeline, table)
        print_json(figures) if self.json else print(text)
        return 0

    def _runs(self) -> Sequence[Run]:
        """Every run of the experiment.

        Raises:
            ConfigError: a number is out of its range.
            UnknownNameError: there is no such experiment.
        """
        from hexwar_sb3.evaluation.seeds import Purpose, seed_for
        from hexwar_sb3.experiments import ablation, fig7, rivals, seeds
        from hexwar_sb3.experiments.runs import Budget

        if self.name not in NAMES:
            raise UnknownNameError("experiment", self.name, (*NAMES, TABLE1))
        check_jobs("jobs", self.jobs)
        if len(set(self.seeds)) < len(self.seeds):
            raise ConfigError(f"name seeds, each of them once; got {self.seeds}")
        for seed in self.seeds:
            seed_for(Purpose.REPORT, seed)
        module = {"fig7": fig7, "ablation": ablation, "seeds": seeds, "rivals": rivals}[self.name]
        budget = Budget(
            games=module.GAMES if self.games is None else self.games,
            eval_games=self.eval_games,
            final_games=module.FINAL_GAMES if self.final_games is None else self.final_games,
        )
        return module.runs(budget, self.seeds or module.SEEDS)

    def _print_states(self, states: Mapping[Run, State], places: Places) -> None:
        if self.json:
            rows = [
                {"run": run.name, "state": state, "command": run.command} for run, state in states.items()
            ]
            print_json({"runs": rows})
        else:
            lines = [[run.name, str(places.kept(run).folder), state] for run, state in states.items()]
            print(table(("run", "results", "state"), lines))


def finish(name: str, runs: Sequence[Run], places: Places) -> list[Path]:
    """Draw the figure, or write the table, from the results that are there; the files."""
    from hexwar_sb3.experiments import ablation, fig7, rivals, seeds

    folder = places.results / name
    if name == ablation.NAME:
        return write_table(runs, places, folder)
    if name == rivals.NAME:
        rows = rivals.summary(runs, places)
        text = table(rivals.HEADS, list(rivals.cells(rows)))
    else:
        rows = seeds.summary(runs, places, seeds.NAMES if name == seeds.NAME else {})
        text = table(seeds.HEADS, list(seeds.cells(rows)))
    made = [folder / "table.txt", folder / "table.json"]
    write_text(made[0], text + "\n")
    write_text(made[1], as_json(rows) + "\n")
    print(text)
    if name == fig7.NAME:
        made.append(folder / "fig7.png")
        fig7.draw(runs, places, made[-1])
    return made


def write_table(runs: Sequence[Run], places: Places, folder: Path) -> list[Path]:
    """Write the table of the ablation as text and as JSON, print it, and draw it."""
    from hexwar_sb3.experiments.ablation import BASE, HEADS, SAYS, cells, summary
    from hexwar_sb3.experiments.ablation_picture import draw

    rows = summary(runs, places)
    text, figures, picture = folder / "table.txt", folder / "table.json", folder / "ablation.png"
    counted = (
        "Mean over seeds [lowest, highest seed], both colours; win rate = (won + drawn / 2) / games.\n"
        f"Margin minus {BASE}: difference of the means over seeds with its 95 % interval (two-sample t)."
    )
    meanings = table(("row", "what differs from base"), [[row["row"], SAYS[row["row"]]] for row in rows])
    lines = "\n\n".join([counted, table(HEADS, list(cells(rows))), meanings])
    write_text(text, lines + "\n")
    write_text(figures, as_json(rows) + "\n")
    print(lines)
    draw(rows, runs, places, picture)
    return [text, figures, picture]


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
