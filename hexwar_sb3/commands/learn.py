"""`hexwar learn`: QMIX on a cooperative game of another library."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from hexwar_sb3.commands.device import check_device
from hexwar_sb3.commands.output import as_json, print_json
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.commands.settings import Json, Seed, check_name
from hexwar_sb3.errors import ConfigError, FileFormatError, shortened

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv

    from hexwar_sb3.algorithms.neutral import GameSettings
    from hexwar_sb3.algorithms.qmix import QMIX

ENV = (
    "Gymnasium id, as MODULE:ID where MODULE registers it (lbforaging:Foraging-8x8-2p-2f-coop-v3), or the module of a"
    " PettingZoo env (mpe2.simple_spread_v3)"
)
EVAL_SEED = 1_000_000  # of the first greedy episode; those of the training are below
INTERRUPTED = 130  # exit code after Ctrl-C


@dataclass(frozen=True, kw_only=True)
class Learn:
    """Train QMIX on a cooperative game of another library, with defaults that know nothing of this one.

    The run folder has settings.json, evaluations.csv, learning_curve.png, best_model.zip and model.zip; `QMIX.load` reads
    the models. Ctrl-C saves, and `ENV --resume RUN` goes on; the games that were under way then begin anew.
    """

    env: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ENV", help=ENV)] = ""
    # YAML: learner (arguments of QMIX), env_kwargs, n_envs, team_reward, privileged_state, last_action
    config: Path | None = None
    n_timesteps: int = 1_000_000  # env steps of all games together
    seed: Seed = 0
    eval_freq: int = 50_000  # env steps between two evaluations
    eval_episodes: int = 100  # greedy ones, on the same seeds each time
    device: str = "auto"  # "cpu", "cuda", or what there is
    name: str = "learn"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")  # folder of run folders
    resume: Path | None = None  # run folder of ENV to go on in; all settings but the device are its own
    progress: bool = False  # show a bar
    json: Json = False

    def run(self) -> int:
        """Train, or go on."""
        from hexwar_sb3.folders import holding

        if self.resume is not None:
            asked = self._asked(RunFolder(self.resume))
            with holding(self.resume, "run"):
                return asked.learn(RunFolder(self.resume))
        self.check()
        self.games(1).close()  # a wrong name shows here, before anything is written
        folder = RunFolder.new(self.runs, self.name)
        with holding(folder.path, "run"):
            folder.write_config(self, " ".join(["hexwar", *sys.argv[1:]]))
            write_text(folder.path / "settings.json", as_json(asdict(self.settings)) + "\n")
            return self.learn(folder)

    def check(self) -> None:
        """Check everything that can be checked before games are made.

        Raises:
            ConfigError: a setting is out of its range.
            FileFormatError: the settings' file is broken.
        """
        if not self.env:
            raise ConfigError(f"which env? {ENV}")
        for name in ("n_timesteps", "eval_freq", "eval_episodes"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")
        check_name("name", self.name)
        check_device(self.device)
        self.settings  # noqa: B018  # reads the file

    @property
    def settings(self) -> GameSettings:
        """Settings of the file, or the defaults."""
        from hexwar_sb3.algorithms.neutral import GameSettings, read_settings

        return GameSettings() if self.config is None else read_settings(self.config)

    def games(self, n_envs: int) -> VecEnv:
        """Make games side by side."""
        from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

        from hexwar_sb3.envs.foreign import make_joint

        joint = self.settings.joint
        return VecMonitor(DummyVecEnv([lambda: make_joint(self.env, **joint)] * n_envs))

    def learn(self, folder: RunFolder) -> int:
        """Train in a folder, from its checkpoint where there is one; the exit code."""
        import torch
        from stable_baselines3.common.callbacks import CallbackList
        from stable_baselines3.common.logger import configure

        from hexwar_sb3.callbacks.checkpoint import Checkpoint
        from hexwar_sb3.callbacks.progress import ProgressBar
        from hexwar_sb3.callbacks.returns import ReturnsCallback

        torch.set_num_threads(1)  # its networks are too small for more
        model = self._model(folder)
        print(f"run folder: {folder.path}", file=sys.stderr)
        model.set_logger(configure(str(folder.path / f"from_{model.num_timesteps}"), ["csv"]))
        returns = ReturnsCallback(
            self.eval_freq, self.games(self.settings.n_envs), folder.path,
            episodes=self.eval_episodes, seed=EVAL_SEED, title=f"QMIX on {self.env}, seed {self.seed}",
        )  # fmt: skip
        checkpoint = Checkpoint(self.eval_freq, folder.checkpoint)
        bars = [ProgressBar(self.n_timesteps)] if self.progress else []
        start = monotonic()
        try:
            with checkpoint.on_signal():
                model.learn(
                    self.n_timesteps - model.num_timesteps,
                    callback=CallbackList([returns, checkpoint, *bars]),
                    reset_num_timesteps=False,
                )
        except KeyboardInterrupt:
            saved = folder.checkpoint.exists()
            again = (
                f"; go on with: hexwar learn {self.env} --resume {folder.path}" if saved else ", not saved"
            )
            print(f"\nstopped{again}")
            return INTERRUPTED
        finally:
            model.logger.close()
        model.save(folder.model)
        self._tell(returns.rows, folder, monotonic() - start)
        return 0

    def _model(self, folder: RunFolder) -> QMIX:
        """The model of the checkpoint, or a new one."""
        from hexwar_sb3.algorithms.checkpoint import load_checkpoint
        from hexwar_sb3.algorithms.qmix import QMIX

        env = self.games(self.settings.n_envs)
        if folder.checkpoint.exists():
            return load_checkpoint(folder.checkpoint, env, device=self.device)
        arguments = self.settings.arguments(self.n_timesteps)
        return QMIX("TaskPolicy", env, seed=self.seed, device=self.device, **arguments)

    def _tell(self, rows: list[dict[str, float]], folder: RunFolder, seconds: float) -> None:
        best = max(rows, key=lambda row: row["mean_return"])
        figures = {"env": self.env, "seed": self.seed, "last": rows[-1], "best": best, "seconds": seconds}
        write_text(folder.path / "page.json", as_json(figures) + "\n")
        if self.json:
            print_json(figures)
            return
        for word, row in (("last", rows[-1]), ("best", best)):
            print(
                f"{word}: mean return {row['mean_return']:.3f} of {row['episodes']:.0f} greedy episodes"
                f" (standard error {row['standard_error']:.3f}) after {row['env_steps']:,.0f} env steps"
            )
        print(f"curve: {folder.path / 'learning_curve.png'}")

    def _asked(self, folder: RunFolder) -> Learn:
        """What the run in a folder was asked for.

        Raises:
            FileFormatError: its settings are broken.
            ConfigError: it is a run of another env: that no file says which module is imported, the user names it again.
        """
        found: dict[str, Any] = folder.read_config()
        asked = {}
        for name, kind in (
            ("env", str),
            ("n_timesteps", int),
            ("seed", int),
            ("eval_freq", int),
            ("eval_episodes", int),
        ):
            if type(found.get(name)) is not kind:
                raise FileFormatError(
                    folder.config, name, found=repr(found.get(name)), expected=f"of type {kind.__name__}"
                )
            asked[name] = found[name]
        if asked["env"] != self.env:
            own = shortened(repr(asked["env"]))
            raise ConfigError(
                f"{folder.path} is a run of the env {own}: name it before --resume, got {self.env!r}"
            )
        config = folder.path / "settings.json"
        again = Learn(**asked, config=config, device=self.device, progress=self.progress, json=self.json)
        again.check()
        return again
