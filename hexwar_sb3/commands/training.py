"""A training run: env, model and callbacks put together, and what is left behind."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, process_time
from typing import TYPE_CHECKING, Any, cast

import torch
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import Logger, configure

from hexwar_sb3.algorithms.beside import executor
from hexwar_sb3.algorithms.checkpoint import load_checkpoint
from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.checkpoint import Checkpoint
from hexwar_sb3.callbacks.progress import ProgressBar
from hexwar_sb3.callbacks.record import write_album, write_games
from hexwar_sb3.callbacks.self_play import SelfPlayCallback
from hexwar_sb3.callbacks.shares import shares_of
from hexwar_sb3.callbacks.win_rate import WinRateCallback
from hexwar_sb3.commands.albums import run_album, save_at_end
from hexwar_sb3.commands.device import check_device
from hexwar_sb3.commands.output import print_json
from hexwar_sb3.commands.page import TRAINED, met_by, write_page
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train_settings import LEARNED, TrainSettings
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.opponents import SELF, with_weights
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, FrozenLower

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv

LED_BY_HEURISTIC = "trained, heuristic lower"  # row of the page
LOG_EVERY_GAMES = 200
INTERRUPTED = 130  # exit code after Ctrl-C


def train(settings: TrainSettings, model: QMIX, folder: RunFolder) -> int:
    """Train as the settings say; return the exit code."""
    start = monotonic()
    threads = torch.get_num_threads()
    model.beside = executor(threads)
    torch.set_num_threads(1)  # else sums would have other bits
    print(f"run folder: {folder.path}", file=sys.stderr)
    if model.num_timesteps == 0:
        model.policy.freeze(**about(settings)).save(folder.untrained)
    if not learn(model, settings, folder, threads):
        saved = folder.checkpoint.exists()
        print(
            f"\nstopped; go on with: hexwar train --resume {folder.path}" if saved else "\nstopped, not saved"
        )
        return INTERRUPTED
    model.save(folder.model)
    del model.replay_buffer  # 1 GB that the games of the page can have
    print("trained; now the games of the page: about half a minute", file=sys.stderr)
    opponent = settings.named_opponents[0]
    write_games(
        folder.policy, opponent, settings.evaluation(), folder.replays, f"against_{Path(opponent).name}"
    )
    if write_album(folder.snapshots, opponent, settings.evaluation(), folder.replays):
        save_at_end(lambda: run_album(folder.path), folder.album)
    title = (
        f'What was learned on "{settings.scenario}", seed {settings.seed}:'
        f" {settings.n_timesteps:,} env steps against {', '.join(settings.met)}"
    )
    before = folder.minutes_before()
    figures, text = write_page(
        folder,
        players_of(settings, folder),
        settings.evaluation(),
        title=title,
        n_timesteps=settings.n_timesteps,
        minutes=(monotonic() - start) / 60 + before,
        core_minutes=process_time() / 60 + before,
        met=met_by(cast("VecEnv", model.env)),
        threads=threads,
    )
    if settings.json:
        print_json({**figures, "run": str(folder.path)})
    else:
        print(text, _places(folder), sep="\n\n")
    return 0


def players_of(settings: TrainSettings, folder: RunFolder) -> dict[str, object]:
    """Say who plays for the page, by the name of the row: "trained" is the best model of the evaluations."""
    trained = FrozenPolicy.load(folder.policy)
    players: dict[str, object] = {"untrained": str(folder.untrained), TRAINED: trained}
    if isinstance(trained.lower, FrozenLower):
        players[LED_BY_HEURISTIC] = trained.led_by(HEURISTIC_LOWER)
    if settings.constant_plans:
        players |= {name: name for name in CONSTANT_PLANS}
    return players


def _places(folder: RunFolder) -> str:
    places = {
        "policy to share": folder.policy,
        "best model": folder.path / "best_model.zip",
        "last model": folder.model,
        "learning curve": folder.path / "learning_curve.png",
        "replays, of its snapshots too": folder.replays,
        "how it changed, to watch": folder.album,
        "this page": folder.page,
    }
    width = max(len(name) for name in places)
    return "\n".join(f"{name:<{width}}  {path}" for name, path in places.items())


def learn(model: QMIX, settings: TrainSettings, folder: RunFolder, threads: int) -> bool:
    """Let the model learn, and play in so many threads meanwhile; False after Ctrl-C."""
    model.set_logger(new_logger(folder.path))
    checkpoint = Checkpoint(settings.save_freq, folder.checkpoint)
    try:
        with checkpoint.on_signal():
            model.learn(
                settings.n_timesteps - model.num_timesteps,
                # The checkpoint last: what else is due at this step is then done, or due again after a resume.
                callback=CallbackList([*watchers(settings, folder, threads), checkpoint]),
                log_interval=LOG_EVERY_GAMES,
                reset_num_timesteps=False,
            )
    except KeyboardInterrupt:
        return False
    finally:
        model.logger.close()
    return True


def make_env(settings: TrainSettings) -> VecEnv:
    """Make the games that the model learns from."""
    return make_vec_env(
        "HexWarTask-v0",
        seed=seed_for(Purpose.TRAINING, settings.seed),
        opponent=[one for one in with_weights(settings.met).items() if one[0] != SELF],
        lower=HEURISTIC_LOWER if settings.value("lower") == LEARNED else settings.value("lower"),
        **settings.env,
    )


def go_on(settings: TrainSettings, folder: RunFolder) -> HierarchicalQMIX:
    """Load the model of a run that was broken off.

    Raises:
        CheckpointError: its checkpoint is missing or broken.
        ConfigError: the run is finished, or its device cannot be used.
    """
    check_device(settings.device)
    env, pool = make_env(settings), self_play(settings, folder)
    for one in pool:
        one.seat(env)
    model = cast(
        "HierarchicalQMIX",
        load_checkpoint(folder.checkpoint, env, HierarchicalQMIX, device=settings.device),
    )
    if folder.page.exists() and model.num_timesteps >= settings.n_timesteps:
        raise ConfigError(
            f"this run is finished: {folder.page}; `hexwar train -i {folder.model}` starts from its model"
        )
    return model


def new_model(settings: TrainSettings, env: VecEnv) -> HierarchicalQMIX:
    """Build a model, or take the one that training is to start from."""
    check_device(settings.device)
    phases = settings.value("phase_ticks")
    levels: dict[str, Any] = {
        "phase_ticks": phases if settings.value("lower") == LEARNED else (phases[0], 0),
        "route_kwargs": settings.route,
        "tie": settings.value("tie"),
        "lower_kwargs": settings.lower_learner,
    }
    if settings.trained_agent is None:
        how = {"seed": settings.seed, "device": settings.device, **settings.learner, **levels}
        return HierarchicalQMIX("HierarchicalPolicy", env, **how)
    model = HierarchicalQMIX.load(settings.trained_agent, env, device=settings.device, seed=settings.seed)
    model.num_timesteps = 0
    return model


def about(settings: TrainSettings) -> dict[str, str]:
    """Say in a policy folder what it was trained on."""
    rules = load_world(settings.scenario).ruleset.hash
    return {"rules": rules, "side": settings.side, "seed": str(settings.seed), **settings.terms.about()}


def watchers(settings: TrainSettings, folder: RunFolder, threads: int = 1) -> list[BaseCallback]:
    """Build the callbacks that look at the training."""
    evaluation = settings.evaluation(games=settings.eval_games, purpose=Purpose.SELECTION)
    how: Any = {
        "folder": folder.path,
        "about": about(settings),
        "threads": threads,
        "snapshots": folder.snapshots,
    }
    win_rate = WinRateCallback(settings.eval_freq, settings.named_opponents, evaluation, **how)
    bar = [ProgressBar(settings.n_timesteps)] if settings.progress else []
    return [*shares_of(settings.chosen, settings.games), *self_play(settings, folder), win_rate, *bar]


def self_play(settings: TrainSettings, folder: RunFolder) -> list[SelfPlayCallback]:
    """Build the callback that gives the games copies of the learner, if they are among the opponents."""
    others = with_weights(settings.met)
    if SELF not in others:
        return []
    share = others[SELF] / sum(others.values())
    del others[SELF]
    return [
        SelfPlayCallback(settings.self_freq, others=list(others.items()), share=share, folder=folder.pool)
    ]


def new_logger(folder: Path) -> Logger:
    """Log to progress.csv, and to TensorBoard where it is installed; keep what an earlier part wrote."""
    progress = folder / "progress.csv"
    if progress.exists():
        parts = len(list(folder.glob("progress*.csv")))
        progress.rename(folder / f"progress_{parts}.csv")
    return configure(str(folder), ["csv", *(["tensorboard"] if find_spec("tensorboard") else [])])
