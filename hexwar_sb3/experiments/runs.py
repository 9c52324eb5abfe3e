"""A run of an experiment: the command that makes it, and where its folder and its results lie."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import count
from pathlib import Path

from hexwar_sb3.errors import ConfigError, FileFormatError, UnknownNameError
from hexwar_sb3.experiments.kept import Kept
from hexwar_sb3.players.terms import DECISION_TICKS, Terms
from hexwar_sb3.reading import read_bytes

HEXWAR = "hexwar_sb3.cli"  # modules that train
FLAT_DQN, RIVAL_DQN = "hexwar_sb3.commands.flat_dqn", "hexwar_sb3.commands.rival_dqn"
TASK_PPO = "hexwar_sb3.commands.task_ppo"
MOST_COMMAND_BYTES = 1 << 16
NO_PLANS = "--no-constant-plans"  # which are the same for all: one run plays them
EVALUATIONS, CHECKPOINTS = 10, 5  # of a run, evenly over its games


class State(StrEnum):
    """How far a run is."""

    DONE = "done"  # its results are kept
    BROKEN_OFF = "broken off"  # its work folder can be gone on with
    MISSING = "missing"


@dataclass(frozen=True, kw_only=True)
class Budget:
    """What every run of an experiment may use."""

    games: int = 10_000  # of the upper level
    eval_games: int = 64  # an opponent and colour, at each point of a curve
    final_games: int = 2000  # an opponent and colour, on the page at the end

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is below 1.
        """
        for name, value in vars(self).items():
            if value < 1:
                raise ConfigError(f"{name} must be at least 1, got {value}")


@dataclass(frozen=True, kw_only=True)
class Run:
    """One training."""

    experiment: str  # whose folder it lies in; another experiment may share it
    row: str  # what it is called but for its seed
    seed: int
    arguments: tuple[str, ...]
    module: str = HEXWAR
    with_policy: bool = True  # its policy is kept with its results

    @property
    def name(self) -> str:
        """Name of its folders."""
        return f"{self.row}-{self.seed}"

    @property
    def command(self) -> str:
        """Command line that makes it again, but for the place of its run folder."""
        program = "hexwar" if self.module == HEXWAR else f"python -m {self.module}"
        return f"{program} {shlex.join(self.arguments)}"


def hrl_run(
    experiment: str,
    row: str,
    seed: int,
    budget: Budget,
    *flags: str,
    scenario: str = "plain",
) -> Run:
    """A run of `hexwar train`: as many env steps as the games have, evaluated at the same games."""
    steps = Terms(scenario=scenario).env_steps(budget.games)
    numbers = {
        "--seed": seed,
        "--n-timesteps": steps,
        "--decision-ticks": DECISION_TICKS,
        "--eval-freq": max(1, steps // EVALUATIONS),
        "--save-freq": max(1, steps // CHECKPOINTS),
        "--eval-games": budget.eval_games,
        "--final-games": budget.final_games,
    }
    words = ("train", "--scenario", scenario, *_words(numbers), *flags)
    return Run(experiment=experiment, row=row, seed=seed, arguments=words)


def baseline_run(
    module: str,
    experiment: str,
    row: str,
    seed: int,
    budget: Budget,
    *flags: str,
    games: int | None = None,
    scenario: str = "plain",
) -> Run:
    """A run of a baseline: the budget's games, or so many, evaluated as often."""
    games = games or budget.games
    numbers = {
        "--seed": seed,
        "--games": games,
        "--eval-freq": max(1, games // EVALUATIONS),
        "--eval-games": budget.eval_games,
        "--final-games": budget.final_games,
    }
    words = ("--scenario", scenario, *_words(numbers), *flags)
    return Run(experiment=experiment, row=row, seed=seed, arguments=words, module=module)


def _words(numbers: dict[str, int]) -> tuple[str, ...]:
    return tuple(word for flag, value in numbers.items() for word in (flag, str(value)))


@dataclass(frozen=True)
class Places:
    """Where results are kept, and where runs work."""

    results: Path  # committed: RESULTS/EXPERIMENT/runs.json and what lies beside it
    work: Path  # run folders, WORK/EXPERIMENT/RUN_k/

    def kept(self, run: Run) -> Kept:
        """A run's results."""
        return Kept(self.results / run.experiment, run.name)

    def log(self, run: Run) -> Path:
        """What a run prints."""
        return self.work / run.experiment / f"{run.name}.log"

    def folder(self, run: Run) -> Path | None:
        """The newest run folder that this very command has made."""
        found = (self.work / run.experiment).glob(f"{run.name}_*")
        folders = [path for path in found if path.name.rpartition("_")[2].isdecimal()]
        made = [path for path in folders if command_in(path).startswith(f"{run.command} --runs ")]
        return max(made, key=lambda path: int(path.name.rpartition("_")[2]), default=None)

    def next_folder(self, run: Run) -> Path:
        """The first run folder of its name that is free."""
        numbers = (k for k in count(1) if not (self.work / run.experiment / f"{run.name}_{k}").exists())
        return self.work / run.experiment / f"{run.name}_{next(numbers)}"

    def is_trained(self, run: Run) -> bool:
        """A run folder is complete: its page, the last file, was written."""
        folder = self.folder(run)
        return folder is not None and (folder / "page.txt").exists()

    def checkpoint(self, run: Run) -> Path | None:
        """The run folder to resume, if there is one."""
        folder = self.folder(run)
        return folder if folder is not None and (folder / "checkpoint.npz").exists() else None

    def is_kept(self, run: Run) -> bool:
        """The results are there.

        Raises:
            ConfigError: another command made them.
        """
        kept = self.kept(run)
        if kept.is_there and kept.command != run.command:
            raise ConfigError(
                f"{run.name} in {kept.folder} was made by `{kept.command}`, not by `{run.command}`; "
                "choose another --results, or remove its line"
            )
        return kept.is_there

    def state(self, run: Run) -> State:
        """How far a run is."""
        if self.is_kept(run):
            return State.DONE
        return State.BROKEN_OFF if self.is_trained(run) or self.checkpoint(run) else State.MISSING


def command_in(folder: Path) -> str:
    """Command line that a folder was made by; empty if it does not say.

    Raises:
        FileFormatError: its file is broken.
    """
    path = folder / "command.txt"
    if not path.is_file():
        return ""
    data = read_bytes(path, MOST_COMMAND_BYTES, expected="a command line")
    try:
        return data.decode("utf-8").strip()
    except UnicodeDecodeError as error:
        raise FileFormatError(path, "text", found=str(error), expected="a command line in UTF-8") from error


def choose(runs: Sequence[Run], only: Iterable[str]) -> list[Run]:
    """The runs with these names, of a run or of all seeds of a row; all of them if none is named.

    Raises:
        UnknownNameError: nothing has such a name.
    """
    only = list(only)
    known = {name for run in runs for name in (run.row, run.name)}
    for name in only:
        if name not in known:
            raise UnknownNameError("run", name, known)
    return [run for run in runs if not only or run.row in only or run.name in only]
