"""`hexwar train`: what a training can be told."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.settings import Json, ScenarioName, Seed
from hexwar_sb3.errors import ConfigError, FileFormatError


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train a commander with QMIX over task sets, then say what it learned."""

    n_timesteps: Annotated[int, tyro.conf.arg(aliases=("-n",))] = (
        300_000  # env steps: 24 decisions make a game
    )
    seed: Seed = 0
    scenario: ScenarioName = "plain"
    side: Literal["red", "blue", "both"] = "both"  # camp of the commander; both: in turn
    opponents: tuple[str, ...] = ("MA1", "MA2")  # bots' names or policy folders; each game draws one
    decision_ticks: int = 75  # ticks between two decisions
    reward: Literal["paper", "net"] = "net"  # margin by eq. (1), or own minus enemy
    n_envs: int = 32  # games side by side

    preset: Literal["default", "paper"] = "default"  # settings of the learner
    mixer: Literal["qmix", "vdn", "iql"] | None = None  # else the preset's, like those below
    learning_rate: float | None = None
    batch_size: int | None = None
    gamma: float | None = None
    n_steps: int | None = None  # steps of a transition
    gradient_steps: int | None = None  # updates a finished game
    trained_agent: Annotated[Path | None, tyro.conf.arg(aliases=("-i",))] = (
        None  # model.zip to start from, with its own learner settings
    )
    device: str = "auto"

    eval_freq: int = 24_000  # env steps between two evaluations
    eval_games: int = 64  # games an opponent and colour in each of them
    save_freq: int = 24_000  # env steps between two checkpoints
    final_games: int = 500  # games an opponent and colour on the page at the end

    name: str = "commander"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")  # folder of the run folders
    resume: Path | None = None  # run folder to go on with; all other settings are read from it
    progress: Annotated[bool, tyro.conf.arg(aliases=("-P",))] = False  # show a progress bar
    json: Json = False

    def run(self) -> int:
        """Train, or go on with a training."""
        from hexwar_sb3.commands.training import make_env, train

        self._check()
        if self.resume is not None:
            folder = RunFolder(self.resume)
            settings = settings_from(folder)
            settings = replace(settings, progress=self.progress, json=self.json, resume=self.resume)
            return train(settings, make_env(settings), folder)
        env = make_env(self)  # a mistake in the settings shows before there is a folder
        folder = RunFolder.new(self.runs, self.name)
        folder.write_config(self, " ".join(["hexwar", *sys.argv[1:]]))
        return train(self, env, folder)

    def _check(self) -> None:
        for name in ("n_timesteps", "n_envs", "eval_freq", "eval_games", "save_freq", "final_games"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")

    @property
    def learner(self) -> dict[str, Any]:
        """Arguments of QMIX: the preset's, and those that were given."""
        from hexwar_sb3.algorithms.presets import PRESETS

        names = ("mixer", "learning_rate", "batch_size", "gamma", "n_steps", "gradient_steps")
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return {**PRESETS[self.preset], **given}


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
