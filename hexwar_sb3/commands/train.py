"""`hexwar train`: what a training can be told."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from hexwar_sb3.commands.output import compile_first
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.settings import Json, ScenarioName, Seed, check_name
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.seeds import Purpose

EXPLORING_SHARE = 0.4  # of the games, in which epsilon falls to its last value

if TYPE_CHECKING:
    from hexwar_sb3.evaluation.panel import Terms

Steps = Annotated[
    int, tyro.conf.arg(aliases=("-n",), help="env steps: decisions of the camp, 24 make a game")
]
StartFrom = Annotated[
    Path | None,
    tyro.conf.arg(aliases=("-i",), help="model.zip to start from, with its own learner settings"),
]


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train a commander with QMIX over task sets, then say what it learned."""

    n_timesteps: Steps = 300_000
    seed: Seed = 0
    scenario: ScenarioName = "plain"
    side: Literal["red", "blue", "both"] = "both"  # camp of the commander; both: in turn
    opponents: tuple[str, ...] = ("MA1", "MA2")  # bots' names or policy folders; each game draws one
    decision_ticks: int = 75  # ticks between two decisions
    reward: Literal["paper", "net"] = "net"  # margin by eq. (1), or own minus enemy
    n_envs: int = 32  # games side by side

    preset: Literal["default", "paper"] = "default"  # settings of the learner
    mixer: Literal["qmix", "vdn", "iql"] | None = None  # else the preset's, like those below
    learning_rate: float | None = None  # of Adam
    batch_size: int | None = None  # transitions of an update
    gamma: float | None = None  # discount of 75 ticks
    n_steps: int | None = None  # steps of a transition
    gradient_steps: int | None = None  # updates a finished game
    trained_agent: StartFrom = None
    device: str = "auto"  # "cpu", "cuda", or what there is

    eval_freq: int = 24_000  # env steps between two evaluations
    eval_games: int = 64  # games an opponent and colour in each of them
    save_freq: int = 24_000  # env steps between two checkpoints
    final_games: int = 1000  # games an opponent and colour on the page at the end

    name: str = "commander"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")  # folder of the run folders
    resume: Path | None = None  # run folder to go on with; all other settings are read from it
    progress: Annotated[bool, tyro.conf.arg(aliases=("-P",))] = False  # show a progress bar
    json: Json = False

    def run(self) -> int:
        """Train, or go on with a training."""
        from hexwar_sb3.commands.training import go_on, make_env, new_model, train

        self._check()
        if self.resume is not None:
            folder = RunFolder(self.resume)
            settings = settings_from(folder)
            settings = replace(settings, progress=self.progress, json=self.json, resume=self.resume)
            compile_first()
            return train(settings, go_on(settings, folder), folder)
        # A wrong setting shows here, before anything is compiled or written.
        model = new_model(self, make_env(self))
        compile_first()
        folder = RunFolder.new(self.runs, self.name)
        folder.write_config(self, " ".join(["hexwar", *sys.argv[1:]]))
        return train(self, model, folder)

    def terms(self, games: int | None = None, purpose: Purpose = Purpose.REPORT) -> Terms:
        """Say how this commander is measured: by default as on the page at the end."""
        from hexwar_sb3.evaluation.panel import CAMPS, Terms

        return Terms(
            scenario=self.scenario,
            games=games or self.final_games,
            seed=self.seed,
            purpose=purpose,
            decision_ticks=self.decision_ticks,
            camps=CAMPS if self.side == "both" else (self.side,),
        )

    def _check(self) -> None:
        for name in ("n_timesteps", "n_envs", "eval_freq", "eval_games", "save_freq", "final_games"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")
        check_name("name", self.name)
        if not self.opponents:
            raise ConfigError("name at least one opponent")

    @property
    def learner(self) -> dict[str, Any]:
        """Arguments of QMIX: the preset's, and those that were given."""
        from hexwar_sb3.algorithms.presets import PRESETS
        from hexwar_sb3.engine.world import load_world

        names = ("mixer", "learning_rate", "batch_size", "gamma", "n_steps", "gradient_steps")
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        games = self.n_timesteps * self.decision_ticks // load_world(self.scenario).scenario.game_ticks
        exploring = {"exploration_episodes": max(1, int(EXPLORING_SHARE * games))}
        return {**exploring, **PRESETS[self.preset], **given}


def settings_from(folder: RunFolder) -> Train:
    """Read the settings of a run folder.

    Raises:
        FileFormatError: they are missing or broken.
    """
    values = folder.read_config()
    known = Train.__dataclass_fields__
    for key in values:
        if key not in known:
            raise FileFormatError(
                folder.config, key, found="an unknown setting", expected="a setting of `hexwar train`"
            )
    for key in ("runs", "resume", "trained_agent"):
        if values.get(key) is not None:
            values[key] = Path(values[key])
    return Train(**{**values, "opponents": tuple(values.get("opponents", Train.opponents))})
