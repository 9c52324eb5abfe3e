"""`hexwar tune`: an Optuna study over alpha, beta and Delta-t (learning.md, section 6)."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from hexwar_sb3.checks import check_whole
from hexwar_sb3.commands.output import as_json, compile_first, panel_table, print_json, table
from hexwar_sb3.commands.run_folder import write_text
from hexwar_sb3.commands.settings import Json, ScenarioName, check_jobs
from hexwar_sb3.errors import ConfigError

if TYPE_CHECKING:
    from hexwar_sb3.tuning.study import StudySpec

FAILED, INTERRUPTED = 1, 130  # exit codes: no trial was completed; Ctrl-C
NEEDED = ("optuna", "filelock", "scipy")  # of the extra "tune"
ACTIONS = """run: go on with the trials; show: table and pictures; compare: points against the paper's, over fresh seeds;
export: a preset"""


@dataclass(frozen=True, kw_only=True)
class Tune:
    """Search alpha, beta and Delta-t, and what else is asked for: an Optuna study whose trials race.

    A trial is several short trainings of both levels, one a seed, and all trials have the same seeds: whose mean so far
    falls behind is broken off between two trainings. The same command goes on with a study. `hexwar tune export STUDY
    -o my.json` writes its best point as a preset for `hexwar train --preset my.json`.
    """

    action: Annotated[
        Literal["run", "show", "compare", "export"], tyro.conf.Positional, tyro.conf.arg(help=ACTIONS)
    ] = "run"
    study: Annotated[
        tyro.conf.Positional[Path], tyro.conf.arg(help="its folder; in a database its name is the study's")
    ] = Path("runs/study")
    n_trials: int = 30  # of the whole study: completed, pruned or failed by themselves
    workers: int = 1  # trials, or trainings of "compare", side by side, each in a process
    storage: str | None = None  # URL of a database, "sqlite:///study.db"; else a journal in the folder
    # settings to search beside alpha, beta and decision_ticks: learning_rate, batch_size, tau, spots, td_lambda,
    # mixer, hidden
    also: tuple[str, ...] = ()
    # points to try next, as JSON: '{"alpha": 1.0, "beta": 0.5}'; what is not said is sampled
    enqueue: tuple[str, ...] = ()
    preset: str = "default"  # whose other settings all trials have
    sampler: Literal["tpe", "gp", "random", "qmc"] = "tpe"  # draws the points
    # breaks trials off between trainings, by their means so far: all but the better half, or all below the median
    pruner: Literal["halving", "median", "none"] = "halving"
    scenario: ScenarioName = "plain"
    # of the trainings, NAME or NAME=WEIGHT; else the broad mixture of `hexwar train`
    opponents: tuple[str, ...] = ()
    # players or folders that judge
    panel: tuple[str, ...] = ("MA1", "MA2", "nearest", "two-hold", "drawn", "HRL0")
    trainings: int = 4  # of a trial, one after the other: one a seed, from `seed` on
    # game ticks that the lower level learns in a training, of all games together
    lower_ticks: int = 1_250_000
    upper_ticks: int = 4_500_000  # and then the upper level; a game has 1,800
    final_games: int = 100  # that judge a training, against each of the panel and in each colour
    # 0..999999; of the first training of every trial, and the sampler's
    seed: int = 0
    games: int = 2_000  # of "compare", a policy, opponent and colour
    # of the trainings of "compare"; else fresh ones, those that follow a trial's, as many as it has
    seeds: tuple[int, ...] = ()
    trials: tuple[int, ...] = ()  # whose points "compare" takes, or the one of "export"; else the best
    # file of "export" (else tuned.json) or of "compare" (else compare.json in the study's folder)
    output: Annotated[Path | None, tyro.conf.arg(aliases=("-o",))] = None
    json: Json = False

    def run(self) -> int:
        """Do it."""
        if missing := [name for name in NEEDED if find_spec(name) is None]:
            raise ConfigError(f'tuning needs {", ".join(missing)}: pip install "hexwar-sb3[tune]"')
        from hexwar_sb3.evaluation.matches import check_games

        check_jobs("workers", self.workers)
        check_games(self.games)
        from hexwar_sb3.tuning.store import database_errors
        from hexwar_sb3.tuning.study import known_spec

        with database_errors():
            if self.action == "run":
                return self._run()
            spec = known_spec(self.study, self.storage)
            return {"show": self._show, "compare": self._compare, "export": self._export}[self.action](spec)

    def _run(self) -> int:
        """Go on with the trials."""
        from hexwar_sb3.tuning.objective import Common
        from hexwar_sb3.tuning.space import checked_point
        from hexwar_sb3.tuning.study import StudySpec, run_study

        names = Common.__dataclass_fields__
        common = Common(**{name: value for name, value in vars(self).items() if name in names})
        spec = StudySpec(
            folder=self.study,
            storage=self.storage,
            also=self.also,
            preset=self.preset,
            sampler=self.sampler,
            pruner=self.pruner,
            common=common,
        )
        check_whole("n_trials", self.n_trials, least=1)
        points = [checked_point(_point(text), spec.space) for text in self.enqueue]
        compile_first(scenario=self.scenario)
        try:
            study = run_study(spec, self.n_trials, self.workers, _say, points)
        except KeyboardInterrupt:
            print("\nstopped; the same command goes on", file=sys.stderr)
            return INTERRUPTED
        self._show(spec)
        if any(one.state.name == "COMPLETE" for one in study.get_trials(deepcopy=False)):
            return 0
        _say("no trial was completed")
        return FAILED

    def _show(self, spec: StudySpec) -> int:
        """Print the trials, and write the pictures."""
        from hexwar_sb3.tuning.pictures import draw_study
        from hexwar_sb3.tuning.study import begin
        from hexwar_sb3.tuning.summary import in_words, summary

        study = begin(spec)
        figures = {**summary(study, spec), "pictures": [str(path) for path in draw_study(study, spec.folder)]}
        print_json(figures) if self.json else print(in_words(figures, table))
        return 0

    def _compare(self, spec: StudySpec) -> int:
        """Let points and the paper's play fresh games."""
        from hexwar_sb3.tuning.final import compare

        compile_first(scenario=spec.common.scenario)
        found = compare(spec, self.games, self.seeds, self.workers, self.trials)
        write_text(self.output or spec.folder / "compare.json", as_json(found) + "\n")
        if self.json:
            print_json(found)
            return 0
        print(panel_table(found["rows"]), _seeds_in_words(**found["seeds"]), sep="\n\n")
        for name, differences in found["minus_paper"].items():
            for games, by_measure in differences.items():
                for what, one in by_measure.items():
                    low, high = one["interval"]
                    print(
                        f"{name} minus paper, {what}, {games}: {one['value']:+.2f} [{low:+.2f}, {high:+.2f}]"
                    )
        return 0

    def _export(self, spec: StudySpec) -> int:
        """Write a point as a preset."""
        from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
        from hexwar_sb3.tuning.study import begin, completed

        if len(self.trials) > 1:
            raise ConfigError(f"a preset has the point of one trial, not of {len(self.trials)}")
        (trial,) = completed(begin(spec), self.trials)
        path = self.output or Path("tuned.json")
        about = {
            "study": spec.folder.name,
            "trial": trial.number,
            "value": trial.value,
            "point": trial.params,
        }
        save_preset(path, load_preset(spec.preset).changed(trial.params), about)
        print_json({"preset": str(path), **about}) if self.json else print(
            f"trial {trial.number} ({trial.value:+.3f}): hexwar train --preset {path}"
        )
        return 0


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _seeds_in_words(compared: Sequence[int], study: Sequence[int]) -> str:
    """Which trainings are compared, and whether the points were chosen by some of them."""
    own = [seed for seed in compared if seed in study]
    chose = f"the study chose by {', '.join(map(str, study))}"
    fresh = f"of these {', '.join(map(str, own))} chose too" if own else "these are fresh"
    return f"trainings with the seeds {', '.join(map(str, compared))}; {chose}: {fresh}"


def _point(text: str) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"a point is a JSON object, got {text[:80]!r}: {error}") from error
