"""One valid file or folder of every kind, small, always the same, made in seconds.

Places within the root, which is the working folder while they are made and while they are loaded, so that
files can name the scenario: `small.scenario.json` beside the folders `map`, `replay`, `qmix` and so on.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from hexwar_sb3.players.terms import Terms

SCENARIO = "small.scenario.json"
ONE_FILE = "policy.safetensors"
MODEL, CHECKPOINT, POLICY, WEIGHTS = "model.zip", "checkpoint.npz", "config.json", "weights.safetensors"
GAME_TICKS = 300
BOARD = """
    map     plain-13x9
    point   main 0705 80
    point   near 0507 30
    point   far 0907 30
    cell    0703 0707 concealed
    cell    0105 0205 0305 0405 0505 0605 0705 0805 0905 1005 1105 1205 1305 paved
    red     tank 0104
    red     chariot 0204
    red     soldier aboard chariot0
    red     aerocraft 0105
    blue    tank 1204
    blue    chariot 1104
    blue    soldier aboard chariot0
    blue    aerocraft 1305
"""
SMALL_NETS = {"hidden": 8, "embed": 8}
SMALL_REPLAY = {"buffer_size": 40, "batch_size": 4}
STEPS = 12  # env steps of two games side by side: some games end
TRAINED = 1_000_000  # ticks that no trial of the study reaches


def make_all(root: Path) -> None:
    """Make everything, in the order in which one needs the other."""
    root.mkdir(parents=True, exist_ok=True)
    with inside(root):
        for make in (games_files, policies, models, checkpoints, run_folder, results, league, study, terrain):
            make(root)


@contextmanager
def inside(root: Path) -> Iterator[None]:
    """Work in a folder."""
    before = Path.cwd()
    os.chdir(root)
    try:
        yield
    finally:
        os.chdir(before)


def games_files(root: Path) -> None:
    """Map, scenario with it and by its name, replays, hot spots."""
    from hexwar_sb3.engine.text import parse_board
    from hexwar_sb3.engine.world import load_world
    from hexwar_sb3.maps.files import save_map, save_scenario
    from hexwar_sb3.play.recording import record_game
    from hexwar_sb3.tasks.hotspots import static_hot_spots

    board = parse_board(BOARD).scenario
    scenario = replace(board, name="small", game_ticks=GAME_TICKS)
    save_scenario(scenario, root / SCENARIO)
    save_scenario(scenario, root / "scenario" / SCENARIO)
    save_scenario(scenario, root / "named" / SCENARIO, "small.map.json")
    for folder in ("map", "named"):
        save_map(scenario.hexmap, root / folder / "small.map.json")
    replay = record_game("MA1", "MA2", Terms(scenario=scenario), seed=1)
    replay.save(root / "replay" / "game.hwr")
    replay.for_camp("red").save(root / "camp" / "red.hwr")
    static_hot_spots(load_world(scenario)).save(root / "spots" / "spots.json")


def new_games(n_envs: int = 2, **settings: Any) -> Any:
    """Games of the task env on the small scenario."""
    from hexwar_sb3.envs.registration import make_vec_env

    how = {"scenario": SCENARIO, "opponent": "drawn", "privileged_state": True, **settings}
    return make_vec_env(n_envs=n_envs, seed=3, **how)


def new_routes() -> Any:
    """Games of the route env."""
    from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env

    return make_vec_env(ROUTE_ENV, n_envs=2, seed=3, scenario=SCENARIO)


def new_qmix(seed: int = 0) -> Any:
    """The smallest one."""
    from hexwar_sb3.algorithms.qmix import QMIX

    how: dict[str, Any] = {**SMALL_REPLAY, "learning_starts": 4, "policy_kwargs": SMALL_NETS, "device": "cpu"}
    return QMIX("TaskPolicy", new_games(), seed=seed, **how)


def new_hierarchical() -> Any:
    """With a first phase of the lower level."""
    from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX

    how: dict[str, Any] = {**SMALL_REPLAY, "learning_starts": 4, "policy_kwargs": SMALL_NETS, "device": "cpu"}
    route = {"n_envs": 2, "scenario": [SCENARIO]}
    lower = {"buffer_size": 60, "batch_size": 4}
    phases: dict[str, Any] = {"phase_ticks": (600, 600), "route_kwargs": route, "lower_kwargs": lower}
    return HierarchicalQMIX("HierarchicalPolicy", new_games(), seed=0, **phases, **how)


def new_masked() -> Any:
    """A DQN of the lower level."""
    from hexwar_sb3.algorithms.masked_dqn import MaskedDQN

    how: dict[str, Any] = {"buffer_size": 60, "batch_size": 4, "learning_starts": 4, "device": "cpu"}
    return MaskedDQN("MultiInputPolicy", new_routes(), seed=0, **how)


def policies(root: Path) -> None:
    """A policy led by the heuristic, one with a lower level, a lower level alone, and others to take files from."""
    from hexwar_sb3.players.frozen_lower import fastest_way_network
    from hexwar_sb3.players.policy_file import save_policy_file
    from hexwar_sb3.rules.ruleset import default_rules

    about = {
        "rules": default_rules().hash,
        "scenario": SCENARIO,
        "decision_ticks": "75",
        "spots": "6",
        "early": "no",
    }
    policy = new_qmix().policy.freeze(**about)
    policy.save(root / "policy")
    levels = policy.led_by(fastest_way_network())
    levels.save(root / "levels")
    save_policy_file(levels, root / "one_file" / ONE_FILE)
    fastest_way_network().save(root / "lower")
    new_qmix(seed=5).policy.freeze(**about).save(root / "others" / "policy")


def models(root: Path) -> None:
    """Model zips of three classes after a little training, and a replay."""
    for name, model, steps in (
        ("qmix", new_qmix(), STEPS),
        ("hierarchical", new_hierarchical(), STEPS),
        ("masked", new_masked(), STEPS),
    ):
        model.learn(steps)
        model.save(root / name / "model.zip")
        if name == "qmix":
            (root / "steps").mkdir()
            model.save_replay_buffer(root / "steps" / "replay.npz")


def checkpoints(root: Path) -> None:
    """Checkpoints of both kinds in the middle of games."""
    from hexwar_sb3.algorithms.checkpoint import save_checkpoint

    for name, model in (("checkpoint", new_qmix()), ("levels_checkpoint", new_hierarchical())):
        model.learn(STEPS - 2)
        save_checkpoint(model, root / name / "checkpoint.npz")


def run_folder(root: Path) -> None:
    """A preset, and a run that was broken off after a few steps."""
    from hexwar_sb3.algorithms.checkpoint import save_checkpoint
    from hexwar_sb3.algorithms.preset_file import save_preset
    from hexwar_sb3.algorithms.presets import PRESETS
    from hexwar_sb3.commands.run_folder import RunFolder
    from hexwar_sb3.commands.train import Train
    from hexwar_sb3.commands.training import make_env, new_model

    small = {**SMALL_NETS, "batch_size": 4, "n_envs": 2, "demo_share": 0.0, "demo_games": 1}
    preset = PRESETS["default"].changed({**small, "phase_ticks": (600, 600), "learning_rate": 1e-3})
    lower = {"buffer_size": 100, "batch_size": 4, "learning_rate": 1e-3}
    learner = {**preset.learner, "n_steps": 2, "exploration_episodes": 10}
    preset = replace(preset, learner=learner, lower_learner=lower, route={"alpha": 0.02, "beta": 0.05})
    save_preset(root / "preset" / "preset.json", preset, {"study": "none"})
    how: dict[str, Any] = {"opponents": ("MA1",), "preset": "preset.json", "device": "cpu", "final_games": 1}
    settings = Train(n_timesteps=STEPS, scenario=SCENARIO, name="small", eval_games=1, **how)
    folder = RunFolder(root / "run")
    folder.path.mkdir()
    shutil.copyfile(root / "preset" / "preset.json", folder.preset)
    settings = replace(settings, preset=str(folder.preset))
    model = new_model(settings, make_env(settings))
    folder.write_config(replace(settings, preset="preset.json"), "hexwar train")
    model.learn(4)
    save_checkpoint(model, folder.checkpoint)


def results(root: Path) -> None:
    """Evaluations, matches of a tournament."""
    from hexwar_sb3.evaluation.history import History
    from hexwar_sb3.evaluation.matches import Evaluation
    from hexwar_sb3.evaluation.panel import play_panel

    history, how = History(), Evaluation(terms=Terms(scenario=SCENARIO), games=2)
    for steps in (24, 48):
        history.add(steps, 75 * steps, play_panel("MA1", ["MA2"], how, name="MA1"))
    (root / "curve").mkdir()
    history.save(root / "curve" / "evaluations.npz")
    play_tournament(root / "tournament")


def play_tournament(folder: Path) -> Any:
    """Play what is missing of it, and read all."""
    from hexwar_sb3.evaluation.matches import Evaluation
    from hexwar_sb3.evaluation.tournament import play_meetings, single_round_robin

    players = {"MA1": "MA1", "MA2": "MA2"}
    meetings = single_round_robin(list(players), [SCENARIO])
    return play_meetings(
        meetings, players, players, Evaluation(terms=Terms(scenario=SCENARIO), games=4), folder
    )


def league_settings() -> Any:
    """One iteration, two groups would be too many: one."""
    from hexwar_sb3.league.settings import LeagueSettings

    learner = {"learning_starts": 0, "buffer_size": 100, "batch_size": 4, "learning_rate": 1e-3}
    games = {"games": 2, "fill_games": 0, "refit_games": 0, "match_games": 2, "warm_up_games": 2, "n_envs": 2}
    how: dict[str, Any] = {**games, "learner": learner, **SMALL_NETS, "opponents": ("MA1",)}
    return LeagueSettings(iterations=1, keep=1, scenario=SCENARIO, **how)


def league(root: Path) -> None:
    """A league after its first iteration."""
    from hexwar_sb3.league.league import League

    League.create(root / "league", league_settings(), {"one": root / "policy"}).run()


def study_spec(folder: Path) -> Any:
    """A study of three trials."""
    from hexwar_sb3.tuning.objective import Common
    from hexwar_sb3.tuning.study import StudySpec

    common = Common(
        scenario=SCENARIO, opponents=("MA1",), panel=("MA1",), lower_ticks=TRAINED, upper_ticks=TRAINED
    )
    return StudySpec(folder=folder, common=common, sampler="random", pruner="none")


def study(root: Path) -> None:
    """A study whose trials were completed, one pruned, one failed, none of them trained."""
    import optuna

    from hexwar_sb3.tuning.study import REASON, begin

    study = begin(study_spec(root / "study"))
    attributes = {"ticks": 2 * TRAINED, "win_rate": 0.5, "trainings": [0.25, -0.5]}
    ends = [optuna.trial.TrialState.COMPLETE] * 2 + [
        optuna.trial.TrialState.PRUNED,
        optuna.trial.TrialState.FAIL,
    ]
    for number, state in enumerate(ends):
        trial = study.ask(dict(study_spec(root / "study").space))
        for name, value in attributes.items():
            trial.set_user_attr(name, value)
        if state == optuna.trial.TrialState.FAIL:
            trial.set_user_attr(REASON, "it failed")
        trial.report(0.1 * number, 1)
        study.tell(trial, 0.1 * number if state == optuna.trial.TrialState.COMPLETE else None, state)


def terrain_map(size: str = "26x25") -> Any:
    """A map whose tables are just large enough to be filed."""
    from hexwar_sb3.engine.text import parse_board

    return parse_board(BOARD.replace("plain-13x9", f"plain-{size}")).scenario.hexmap


def terrain(root: Path) -> None:
    """A cache folder: tables of two maps, and the compiled kernels of the real one, linked."""
    from hexwar_sb3.cache import cache_root

    cache = root / "terrain" / "cache"
    real = cache_root()
    assert real is not None
    (cache / "terrain").mkdir(parents=True)
    with cache_at(cache):
        tables(terrain_map())
        tables(terrain_map("25x26"))
    for kernels in real.glob("*"):
        if kernels.name != "terrain" and not (cache / kernels.name).exists():
            (cache / kernels.name).symlink_to(kernels)


@contextmanager
def cache_at(folder: Path) -> Iterator[None]:
    """Let the cache lie elsewhere."""
    before = os.environ.get("HEXWAR_CACHE")
    os.environ["HEXWAR_CACHE"] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ["HEXWAR_CACHE"]
        else:
            os.environ["HEXWAR_CACHE"] = before


def tables(hexmap: Any) -> list[Any]:
    """The tables of a map, from files where there are some."""
    from hexwar_sb3.maps.terrain import Terrain
    from hexwar_sb3.rules.ruleset import default_rules

    terrain = Terrain(hexmap, default_rules())
    return [terrain.cells, terrain.los]


if __name__ == "__main__":
    make_all(Path(sys.argv[1]))
