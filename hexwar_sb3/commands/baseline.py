"""A baseline of another library, trained and measured as `hexwar train`: what all of them share.

They leave model, best model, curve and page as `hexwar train` does; no policy folder, replays or checkpoints: a run
that was broken off starts anew.
"""

from __future__ import annotations

import sys
from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, process_time
from typing import Any, ClassVar, Literal, cast

import torch
import tyro
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hexwar_sb3.callbacks.win_rate import WinRateCallback
from hexwar_sb3.commands.console import carry_out, one_line_errors
from hexwar_sb3.commands.output import compile_first
from hexwar_sb3.commands.page import TRAINED, write_page
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.settings import ConstantPlans, ScenarioName, Seed, check_name
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.opponents import named, with_weights
from hexwar_sb3.evaluation.panel import BOTS, CONSTANT_PLANS
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.files import replacing
from hexwar_sb3.folders import holding
from hexwar_sb3.players.terms import DECISION_TICKS, Terms


@dataclass(frozen=True, kw_only=True)
class Baseline:
    """Train a model for a number of games, then say what was learned."""

    title: ClassVar[str]  # in sentences
    module: ClassVar[str]  # run as `python -m`
    algorithm: ClassVar[type[BaseAlgorithm]]
    env: ClassVar[str]

    games: int = 10_000
    seed: Seed = 0
    scenario: ScenarioName = "plain"
    opponents: tuple[str, ...] = BOTS  # each game draws one
    decision_ticks: int = DECISION_TICKS
    n_envs: int = 16  # games side by side
    reward: Literal["paper", "net"] = "net"  # margin by eq. (1), or own minus enemy
    reward_scale: float = 50.0  # points that count as 1

    eval_freq: int = 1000  # games between two evaluations
    eval_games: int = 64  # games an opponent and colour in each of them
    final_games: int = 1000  # games an opponent and colour on the page at the end
    constant_plans: ConstantPlans = True

    name: str = "baseline"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")

    @property
    def env_settings(self) -> dict[str, Any]:
        """Further settings of the env."""
        return {}

    @abstractmethod
    def new_model(self) -> BaseAlgorithm:
        """The untrained model with its env."""

    @property
    @abstractmethod
    def most_steps(self) -> int:
        """Env steps that the games have at most."""

    def run(self) -> int:
        """Train."""
        for name in ("games", "n_envs", "eval_freq", "eval_games", "final_games"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")
        check_name("name", self.name)
        torch.set_num_threads(1)  # its networks are too small for more
        model = self.new_model()
        compile_first()
        self.evaluation().check_opponents(named(self.opponents))
        folder = RunFolder.new(self.runs, self.name)
        with holding(folder.path, "run"):
            return self._train(model, folder)

    def _train(self, model: BaseAlgorithm, folder: RunFolder) -> int:
        folder.write_config(self, " ".join([f"python -m {self.module}", *sys.argv[1:]]))
        start = monotonic()
        self.learn(model, folder)
        title = (
            f'What {self.title} learned on "{self.scenario}", seed {self.seed}:'
            f" {self.games:,} games against {', '.join(self.opponents)}"
        )
        _, text = write_page(
            folder,
            self.players(folder),
            self.evaluation(Purpose.REPORT),
            title=title,
            n_timesteps=self.games * self.decisions,
            minutes=(monotonic() - start) / 60,
            core_minutes=process_time() / 60,
        )
        print(text)
        return 0

    def players(self, folder: RunFolder) -> dict[str, object]:
        """Say who plays for the page, by the name of the row: "trained" is the best model of the evaluations."""
        players: dict[str, object] = {
            "untrained": self.algorithm.load(untrained(folder), device="cpu"),
            TRAINED: self.algorithm.load(best(folder.path), device="cpu"),
        }
        if self.constant_plans:
            players |= {name: name for name in CONSTANT_PLANS}
        return players

    def learn(self, model: BaseAlgorithm, folder: RunFolder) -> None:
        """Let the model play its games."""
        save_whole(model, untrained(folder))
        model.set_logger(configure(str(folder.path), ["csv"]))
        watch = GamesWinRate(
            self.decisions, self.eval_freq, named(self.opponents), self.evaluation(), folder=folder.path
        )
        try:
            callback = CallbackList([*self.watchers(), watch, UntilGames(self.games)])
            model.learn(self.most_steps, callback=callback, log_interval=200)
        finally:
            model.logger.close()
        save_whole(model, folder.model)

    def watchers(self) -> list[BaseCallback]:
        """Further callbacks of the training."""
        return []

    def make_env(self) -> VecEnv:
        """Make the games that it learns from."""
        env = make_vec_env(
            self.env,
            self.n_envs,
            seed_for(Purpose.TRAINING, self.seed),
            side="both",
            opponent=list(with_weights(self.opponents).items()),
            **self.terms.settings,
            reward=self.reward,
            **self.env_settings,
        )
        return ScaledGames(env, self.reward_scale)

    @property
    def terms(self) -> Terms:
        """How its games are played."""
        return Terms(scenario=self.scenario, decision_ticks=self.decision_ticks)

    def evaluation(self, purpose: Purpose = Purpose.SELECTION) -> Evaluation:
        """Say how it is measured: while it learns, or on the page at the end."""
        games = self.eval_games if purpose == Purpose.SELECTION else self.final_games
        return Evaluation(terms=self.terms, games=games, seed=self.seed, purpose=purpose)

    @property
    def decisions(self) -> int:
        """Decisions of a game: env steps of the task env."""
        return self.terms.env_steps(1)


class ScaledGames(VecEnvWrapper):
    """Divides rewards, so that values are about 1, and counts games; episode records stay in points."""

    def __init__(self, venv: VecEnv, scale: float) -> None:
        super().__init__(venv)
        self.scale, self.finished = scale, 0

    def reset(self) -> VecEnvObs:
        """Start anew."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Step, then scale."""
        obs, reward, done, infos = self.venv.step_wait()
        self.finished += int(done.sum())
        return obs, reward / self.scale, done, infos


class GamesWinRate(WinRateCallback):
    """The same evaluations at the same games: env steps are the decisions of the finished games.

    Args:
        decisions: of a game.
        every: games between two evaluations.
        args, kwargs: of `WinRateCallback`.
    """

    def __init__(self, decisions: int, every: int, *args: Any, **kwargs: Any) -> None:
        super().__init__(every * decisions, *args, **kwargs)
        self.decisions = decisions

    def now(self) -> int:
        """Decisions of the finished games."""
        return finished_games(self.model) * self.decisions

    def ticks(self) -> int:
        """Game ticks of the finished games."""
        return self.now() * self.evaluation.terms.decision_ticks

    def player(self) -> Any:
        """The model itself plays."""
        return self.model

    def keep_best(self, player: Any) -> None:
        """Save the model; it has no policy folder."""
        save_whole(player, best(self.folder))


class UntilGames(BaseCallback):
    """Ends the training after a number of games."""

    def __init__(self, games: int) -> None:
        super().__init__()
        self.games = games

    def _on_step(self) -> bool:
        return finished_games(self.model) < self.games


def finished_games(model: BaseAlgorithm) -> int:
    """Games that its env has finished."""
    return cast("ScaledGames", model.get_env()).finished


def untrained(folder: RunFolder) -> Path:
    """The model before training, for the page."""
    return folder.path / "untrained.zip"


def best(folder: Path) -> Path:
    """The model that did best in the evaluations."""
    return folder / "best_model.zip"


def save_whole(model: BaseAlgorithm, path: Path) -> None:
    """Save a model, at once or not at all."""
    with replacing(path) as temporary:
        model.save(temporary)


def run_baseline(cls: type[Baseline]) -> int:
    """Run a command line; a mistake of the user's ends in one line, so does Ctrl-C: nothing was saved."""
    program = cls.module.rpartition(".")[2]

    def run() -> int:
        with one_line_errors(sys.argv[1:], cls):
            command = tyro.cli(cls, config=(tyro.conf.FlagCreatePairsOff,))
        return command.run()

    return carry_out(program, run, stopped="stopped; it starts anew")
