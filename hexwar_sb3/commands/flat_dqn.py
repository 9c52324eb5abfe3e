"""`python -m hexwar_sb3.commands.flat_dqn`: the paper's baseline of Fig. 7, trained and measured as `hexwar train`.

SB3's own DQN on `HexWarFlat-v0`: a piece's task and direction are one action, and pieces decide in turn. It
leaves the files of `hexwar train`, but for a policy folder and checkpoints: a run that was broken off starts anew.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import torch
import tyro
from stable_baselines3 import DQN
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hexwar_sb3.callbacks.win_rate import WinRateCallback
from hexwar_sb3.commands.bench_start import peak_mb
from hexwar_sb3.commands.output import compile_first, panel_table
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.commands.settings import ScenarioName, Seed
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import FLAT_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError, HexWarError
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS, Terms, play_panel
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.rules.enums import Camp

OPPONENTS = ("MA1", "MA2")
USER_ERROR, INTERRUPTED = 2, 130  # exit codes


@dataclass(frozen=True, kw_only=True)
class FlatDqn:
    """Train the flat DQN for a number of games, then say what was learned."""

    games: int = 10_000
    seed: Seed = 0
    scenario: ScenarioName = "plain"
    opponents: tuple[str, ...] = OPPONENTS  # each game draws one
    decision_ticks: int = 75
    n_envs: int = 16  # games side by side

    gamma: float = 0.99  # discount of a decision; a turn has its root by the number of pieces
    reward_scale: float = 50.0  # points that count as 1
    learning_rate: float = 5e-4
    buffer_size: int = 200_000  # turns; 0.7 GB
    learning_games: int = 16  # before the first update
    batch_size: int = 128
    gradient_steps: int = 1  # updates after a turn of every game
    target_update_turns: int = 16_000
    exploration_share: float = 0.4  # of the turns, in which epsilon falls to its last value
    exploration_initial_eps: float = 0.5
    exploration_final_eps: float = 0.05
    net_arch: tuple[int, ...] = (64, 64)  # SB3's own

    eval_freq: int = 1000  # games between two evaluations
    eval_games: int = 64  # games an opponent and colour in each of them
    final_games: int = 1000  # games an opponent and colour on the page at the end

    name: str = "flat_dqn"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")

    def run(self) -> int:
        """Train."""
        for name in ("games", "n_envs", "eval_freq", "eval_games", "final_games"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")
        torch.set_num_threads(1)
        model = self.new_model()
        compile_first()
        folder = RunFolder.new(self.runs, self.name)
        folder.write_config(self, " ".join(["python -m hexwar_sb3.commands.flat_dqn", *sys.argv[1:]]))
        start = monotonic()
        self.learn(model, folder)
        write_page(self, folder, minutes=(monotonic() - start) / 60)
        return 0

    def learn(self, model: DQN, folder: RunFolder) -> None:
        """Let the model play its games."""
        model.save(untrained(folder))
        model.set_logger(configure(str(folder.path), ["csv"]))
        watch = FlatWinRate(self.decisions, self.eval_freq, self.opponents, self.terms(), folder=folder.path)
        try:
            model.learn(
                self.most_turns, callback=CallbackList([watch, UntilGames(self.games)]), log_interval=200
            )
        finally:
            model.logger.close()
        model.save(folder.model)

    def new_model(self) -> DQN:
        """SB3's own DQN with our settings."""
        return DQN(
            "MlpPolicy",
            self.make_env(),
            seed=self.seed,
            device="cpu",
            gamma=self.gamma ** (1 / self.pieces),
            learning_rate=self.learning_rate,
            buffer_size=self.buffer_size,
            learning_starts=self.learning_games * self.decisions * self.pieces,
            batch_size=self.batch_size,
            train_freq=1,
            gradient_steps=self.gradient_steps,
            target_update_interval=self.target_update_turns,
            exploration_fraction=self.exploration_share,
            exploration_initial_eps=self.exploration_initial_eps,
            exploration_final_eps=self.exploration_final_eps,
            policy_kwargs={"net_arch": list(self.net_arch)},
            optimize_memory_usage=True,  # half the memory; games end by themselves, none is cut short
            replay_buffer_kwargs={"handle_timeout_termination": False},
        )

    def make_env(self) -> VecEnv:
        """Make the games that it learns from."""
        env = make_vec_env(
            FLAT_ENV,
            self.n_envs,
            seed_for(Purpose.TRAINING, self.seed),
            scenario=self.scenario,
            side="both",
            opponent=list(self.opponents),
            decision_ticks=self.decision_ticks,
            reward="net",
            dtype="float16",
        )
        return ScaledReward(env, self.reward_scale)

    def terms(self, purpose: Purpose = Purpose.SELECTION) -> Terms:
        """Say how it is measured: while it learns, or on the page at the end."""
        games = self.eval_games if purpose == Purpose.SELECTION else self.final_games
        return Terms(
            scenario=self.scenario,
            games=games,
            seed=self.seed,
            purpose=purpose,
            decision_ticks=self.decision_ticks,
        )

    @property
    def decisions(self) -> int:
        """Decisions of a game: env steps of the task env."""
        return load_world(self.scenario).scenario.game_ticks // self.decision_ticks

    @property
    def pieces(self) -> int:
        """Pieces of a camp at the start: turns of a decision."""
        side = load_world(self.scenario).side(Camp.RED)
        return int(side.stop - side.start)

    @property
    def most_turns(self) -> int:
        """Turns that the games have if no piece dies."""
        return (self.games + self.n_envs) * self.decisions * self.pieces


class ScaledReward(VecEnvWrapper):
    """Divides rewards, so that values are about 1; episode records stay in points."""

    def __init__(self, venv: VecEnv, scale: float) -> None:
        super().__init__(venv)
        self.scale = scale

    def reset(self) -> VecEnvObs:
        """Start anew."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Step, then scale."""
        obs, reward, done, infos = self.venv.step_wait()
        return obs, reward / self.scale, done, infos


class FlatWinRate(WinRateCallback):
    """The same evaluations at the same games: env steps are the decisions of the finished games, not turns.

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

    def player(self) -> Any:
        """The model itself plays."""
        return self.model

    def keep_best(self, player: Any) -> None:
        """Save the model; it has no policy folder."""
        player.save(self.folder / "best_model.zip")


class UntilGames(BaseCallback):
    """Ends the training after a number of games."""

    def __init__(self, games: int) -> None:
        super().__init__()
        self.games = games

    def _on_step(self) -> bool:
        return finished_games(self.model) < self.games


def finished_games(model: Any) -> int:
    """SB3's own count of episodes."""
    return int(model._episode_num)  # noqa: SLF001


def untrained(folder: RunFolder) -> Path:
    """The model before training, for the page."""
    return folder.path / "untrained.zip"


def write_page(settings: FlatDqn, folder: RunFolder, *, minutes: float) -> None:
    """Play fresh games before and after, beside constant plans; the figures of the page of `hexwar train`."""
    players: dict[str, object] = {
        "untrained": DQN.load(untrained(folder), device="cpu"),
        "trained": DQN.load(folder.path / "best_model.zip", device="cpu"),
        **{name: name for name in CONSTANT_PLANS},
    }
    terms = settings.terms(Purpose.REPORT)
    panels = [play_panel(player, OPPONENTS, terms, name=name) for name, player in players.items()]
    rows = [row for panel in panels for row in panel.summary()]
    steps = settings.games * settings.decisions
    figures = {
        "command": (folder.path / "command.txt").read_text(encoding="utf-8").strip(),
        "seed": settings.seed,
        "n_timesteps": steps,
        "games": settings.final_games,
        **provenance(settings.scenario),
        "minutes": minutes,
        "peak_mb": peak_mb(),
        "rows": rows,
    }
    write_text(folder.path / "page.json", json.dumps(figures, indent=2) + "\n")
    title = (
        f'What the flat DQN learned on "{settings.scenario}", seed {settings.seed}: {settings.games:,} games against '
        f"{', '.join(settings.opponents)} in {minutes:.1f} minutes.\n"
        "Figures: fresh games; win rate = (won + drawn / 2) / games; 95 % intervals."
    )
    text = f"{title}\n\n{panel_table(rows)}"
    write_text(folder.page, text + "\n")
    print(text)


def main() -> int:
    """Run; a mistake of the user's ends in one line, Ctrl-C in none: nothing was saved."""
    try:
        return tyro.cli(FlatDqn, config=(tyro.conf.FlagCreatePairsOff,)).run()
    except (HexWarError, OSError) as error:
        print(f"flat_dqn: {error}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("flat_dqn: stopped; it starts anew", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
