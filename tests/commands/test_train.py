"""A whole training, small: what it leaves behind, and that a broken one goes on."""

from __future__ import annotations

import hashlib
import json
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import cast

import pytest
from safetensors.numpy import load_file

from hexwar_sb3.algorithms.checkpoint import save_checkpoint
from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.commands.page import others_on
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train import Train
from hexwar_sb3.commands.train_settings import LOWER_SCENARIOS
from hexwar_sb3.commands.training import make_env, new_model, players_of
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.route_settings import route_settings
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS
from hexwar_sb3.maps.files import load_scenario, save_scenario
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import fastest_way_network
from hexwar_sb3.players.player import bot_player
from hexwar_sb3.rules.enums import PieceType

Command = Callable[..., tuple[int, str, str]]

SMALL = (
    *("--n-envs", "4", "--opponents", "MA1", "--eval-freq", "200", "--eval-games", "1", "--save-freq", "100"),
    *("--final-games", "2", "--batch-size", "32", "--seed", "3"),
)


def weights_hash(run: Path) -> str:
    """Hash of every network of the last model."""
    model = HierarchicalQMIX.load(run / "model.zip")
    digest = hashlib.sha256()
    for tensor in (*model.policy.state_dict().values(), *model.lower.policy.state_dict().values()):
        digest.update(tensor.numpy().tobytes())
    return digest.hexdigest()


def save_and_press_ctrl_c(model: QMIX, path: Path) -> None:
    first = not path.exists()
    save_checkpoint(model, path)
    if first:
        signal.raise_signal(signal.SIGINT)


def test_a_training_leaves_a_whole_run_folder(hexwar: Command, tmp_path: Path) -> None:
    code, out, _ = hexwar("train", *SMALL, "-n", "400", "--runs", str(tmp_path), "-P")

    run = tmp_path / "commander_1"
    assert code == 0
    assert {path.name for path in run.iterdir()} >= {
        *("config.json", "command.txt", "model.zip", "best_model.zip", "policy", "evaluations.npz"),
        *(
            "progress.csv",
            "learning_curve.png",
            "replays",
            "page.txt",
            "page.json",
            "checkpoint.npz",
            "untrained",
        ),
    }
    assert all(
        word in out
        for word in ("untrained", "trained", "all-main", "MA1", "MA2", "win rate", str(run / "policy"))
    )
    rows = json.loads((run / "page.json").read_text(encoding="utf-8"))["rows"]
    assert {(row["opponent"], row["camp"]) for row in rows} == {
        (o, c) for o in ("MA1", "MA2") for c in ("red", "blue")
    }
    assert load_file(run / "policy" / "weights.safetensors")
    snapshots = sorted(path.name for path in (run / "snapshots").iterdir())
    album = [Replay.load(path) for path in sorted((run / "replays").glob("red_0*.hwr"))]
    assert [replay.head["players"]["red"]["name"] for replay in album] == snapshots
    assert len({replay.seed for replay in album}) == 1  # the same game, again and again


def test_a_commander_meets_itself_and_goes_on_doing_so(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = ("train", *SMALL, "-n", "400", "--opponents", "MA1=2", "self", "--self-freq", "100")
    hexwar(*whole, "--priority", "1", "--runs", str(tmp_path / "whole"))
    monkeypatch.setattr("hexwar_sb3.callbacks.checkpoint.save_checkpoint", save_and_press_ctrl_c)
    hexwar(*whole, "--priority", "1", "--save-freq", "300", "--runs", str(tmp_path / "broken"))
    code, out, _ = hexwar("train", "--resume", str(tmp_path / "broken" / "commander_1"))

    assert code == 0
    assert "itself, earlier" in out
    runs = [tmp_path / name / "commander_1" for name in ("whole", "broken")]
    assert len({weights_hash(run) for run in runs}) == 1
    met = [json.loads((run / "page.json").read_text(encoding="utf-8"))["met"] for run in runs]
    assert met[0] == met[1]
    assert [one["opponent"] for one in met[0]] == ["MA1", "itself, earlier"]
    assert all(one["games"] > 0 for one in met[0])


def test_a_policy_with_a_learned_lower_level_stands_beside_itself_over_the_heuristic(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    policy = QMIX("TaskPolicy", make_vec_env(seed=0), buffer_size=10).policy.freeze()
    for lower, rows in (("heuristic", 0), (fastest_way_network(), 1)):
        policy.led_by(lower).save(folder.policy)

        players = players_of(Train(constant_plans=False), folder)

        others = players.keys() - {"untrained", "trained"}
        assert len(others) == rows
        assert all(cast("FrozenPolicy", players[name]).lower == "heuristic" for name in others)
    assert {*players_of(Train(), folder)} == {*players, *CONSTANT_PLANS}


def ground_alone(folder: Path) -> str:
    """A scenario without aerocraft."""
    plain = load_scenario("plain")
    ground = tuple(piece for piece in plain.pieces if piece.kind != PieceType.AEROCRAFT)
    save_scenario(replace(plain, pieces=ground), folder / "ground.scenario.json", "plain")
    return str(folder / "ground.scenario.json")


def test_a_learned_player_is_met_where_it_fits(tmp_path: Path) -> None:
    mine = ground_alone(tmp_path)

    assert "HRL0=2" in Train().met
    assert "HRL0=2" not in Train(scenario=mine).met
    assert others_on("hills") == (*others_on(mine), "HRL0")
    assert {"two-hold", "drawn-unseen"} <= set(others_on(mine))
    assert not {"MA1", "MA2", "random"} & set(others_on(mine))


def test_the_lower_level_learns_on_maps_that_the_upper_one_fits(tmp_path: Path) -> None:
    mine = ground_alone(tmp_path)

    assert Train(scenario=mine).route["scenario"] == [mine]
    assert Train(scenario="plain").route["scenario"] == [
        "plain",
        *(name for name in LOWER_SCENARIOS if name != "plain"),
    ]
    with pytest.raises(ConfigError, match=r"plain has \(7, 2\) pieces .* has \(6, 2\)"):
        Train(scenario=mine, lower_scenarios=("plain",)).run()


def test_a_larger_war_keeps_fewer_steps_unless_more_are_asked_for() -> None:
    assert Train().learner["buffer_size"] == Train(scenario="skirmish").learner["buffer_size"] == 100_000
    assert 20_000 < Train(scenario="battalion").learner["buffer_size"] < 30_000
    assert Train(scenario="battalion", buffer_size=50_000).learner["buffer_size"] == 50_000


def test_three_against_five_through_training_and_measuring(hexwar: Command, tmp_path: Path) -> None:
    """One policy for both camps, or for one, which is measured and exploited as that one alone."""
    start = (
        "map plain-20x11\npoint main 1006 80\nred tank 0203\nred chariot 0205\nred soldier aboard chariot0\n"
    )
    start += (
        "blue tank 1703\nblue chariot 1705\nblue soldier aboard chariot0\nblue tank 1707\nblue aerocraft 1804"
    )
    mine = str(tmp_path / "mine.scenario.json")
    save_scenario(Game.from_text(start).world.scenario, mine)
    short = (
        "train",
        *SMALL,
        "-n",
        "200",
        "--scenario",
        mine,
        "--decision-ticks",
        "60",
        "--runs",
        str(tmp_path),
    )

    for side, camps in (("both", ["red", "blue"]), ("red", ["red"])):
        assert hexwar(*short, "--side", side, "--name", side, "--no-constant-plans")[0] == 0
        run = str(tmp_path / f"{side}_1")
        code, out, _ = hexwar(
            "evaluate", run, "--games", "2", "--opponents", "MA1", "--no-constant-plans", "--json"
        )
        assert (code, [row["camp"] for row in json.loads(out)["rows"]]) == (0, camps)
    exploit = ("exploit", run, "--games", "8", "--every", "8", "--eval-games", "2", "--seeds", "1", "--json")
    code, out, _ = hexwar(*exploit, "--output", str(tmp_path / "exploit"))
    assert (code, list(json.loads(out)["camps"])) == (0, ["blue"])
    code, out, _ = hexwar("match", run, "nearest", "--games", "2", "--json")
    assert (code, json.loads(out)["scenario"].split()[0]) == (0, Game.from_text(start).world.scenario.name)


def test_a_training_that_starts_from_a_model_has_games_of_its_own(tmp_path: Path) -> None:
    first = Train(seed=1)
    new_model(first, make_env(first)).save(tmp_path / "model.zip")

    second = Train(seed=2, trained_agent=tmp_path / "model.zip")
    model = new_model(second, make_env(second))

    assert model.seed == 2


def test_a_checkpoint_comes_after_what_else_is_due(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run that is stopped by the checkpoint has kept the evaluation of the same step."""
    monkeypatch.setattr("hexwar_sb3.callbacks.checkpoint.save_checkpoint", save_and_press_ctrl_c)
    folder = tmp_path / "commander_1"

    hexwar(
        "train", *SMALL, "-n", "400", "--save-freq", "200", "--lower", "heuristic", "--runs", str(tmp_path)
    )
    hexwar("train", "--resume", str(folder))

    assert [step // 200 for step in History.load(folder / "evaluations.npz").timesteps] == [0, 1, 2]


def test_the_papers_preset_sets_both_levels() -> None:
    """Section IV: "learn rate lr=0.1 and update timestep a=0.1", epsilon from 0.5 to 0.05."""
    settings = Train(preset="paper", seed=1)
    model = new_model(settings, make_env(settings))

    for level in (model, model.lower):
        assert (level.learning_rate, level.tau) == (0.1, 0.1)
        assert (level.exploration_initial_eps, level.exploration_final_eps) == (0.5, 0.05)
    assert (model.gamma, model.n_steps, model.tie, model.n_envs) == (1.0, 1, 0.0, 16)
    route = route_settings(model.route_kwargs)
    assert (route.alpha, route.beta, route.beta_per, route.is_shaped) == (0.01, 0.05, "hop", False)


def test_a_resumed_training_ends_with_the_weights_of_an_unbroken_one(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """architecture.md, section 6: on a CPU, the same weights."""
    arguments = ("train", *SMALL, "-n", "600", "--runs", str(tmp_path))
    with monkeypatch.context() as patch:
        patch.setattr("hexwar_sb3.callbacks.checkpoint.save_checkpoint", save_and_press_ctrl_c)
        stopped, _, _ = hexwar(*arguments, "--name", "broken")

    hexwar("train", "--resume", str(tmp_path / "broken_1"))
    hexwar(*arguments, "--name", "whole")

    assert stopped == 130
    assert weights_hash(tmp_path / "broken_1") == weights_hash(tmp_path / "whole_1")
    broken, whole = (History.load(tmp_path / run / "evaluations.npz") for run in ("broken_1", "whole_1"))
    assert broken.timesteps == whole.timesteps
    assert broken.results[-1].margins.tolist() == whole.results[-1].margins.tolist()


KILLED_AT_THE_SECOND_CHECKPOINT = """
import os, signal
from hexwar_sb3.callbacks import checkpoint
from hexwar_sb3.cli import main
save = checkpoint.save_checkpoint
def save_once(model, path):
    if path.exists():
        os.kill(os.getpid(), signal.SIGKILL)
    save(model, path)
checkpoint.save_checkpoint = save_once
main()
"""


@pytest.mark.slow
def test_a_killed_training_goes_on_to_the_weights_of_an_unbroken_one(hexwar: Command, tmp_path: Path) -> None:
    arguments = ("train", *SMALL, "-n", "600", "--runs", str(tmp_path))
    killed = subprocess.run(
        [sys.executable, "-c", KILLED_AT_THE_SECOND_CHECKPOINT, *arguments, "--name", "killed"], check=False
    )

    hexwar("train", "--resume", str(tmp_path / "killed_1"))
    hexwar(*arguments, "--name", "whole")

    assert killed.returncode == -signal.SIGKILL
    assert weights_hash(tmp_path / "killed_1") == weights_hash(tmp_path / "whole_1")


KILLED_WHILE_IT_WRITES = """
import os, signal, sys
from hexwar_sb3.algorithms import checkpoint, parts
from hexwar_sb3.cli import main
nth, moment = int(sys.argv.pop(1)), float(sys.argv.pop(1))
write, save, saved = parts.npy.write_array, checkpoint.write_arrays, []
def save_and_die(file, arrays):
    saved.append(len(arrays))
    if len(saved) < nth:
        return save(file, arrays)
    left = int(moment * len(arrays))  # arrays that are written before the end
    def write_some(*args, **options):
        nonlocal left
        if left <= 0:
            file.flush()
            os.kill(os.getpid(), signal.SIGKILL)
        left -= 1
        return write(*args, **options)
    parts.npy.write_array = write_some
    save(file, arrays)
    os.kill(os.getpid(), signal.SIGKILL)  # all is written, and the old file is still in its place
checkpoint.write_arrays = save_and_die
main()
"""


@pytest.mark.slow
@pytest.mark.timeout(3_000)  # eleven trainings
def test_a_training_that_is_killed_while_it_writes_goes_on_and_leaves_nothing(
    hexwar: Command, tmp_path: Path
) -> None:
    """At ten moments of writing, in the second and third checkpoint."""
    arguments = ("train", *SMALL, "-n", "320", "--lower", "heuristic", "--runs", str(tmp_path))
    hexwar(*arguments, "--name", "whole")
    whole = weights_hash(tmp_path / "whole_1")
    for k in range(10):
        nth, moment = str(2 + k % 2), str(k / 9)
        run = tmp_path / f"killed{k}_1"
        killed = subprocess.run(
            [sys.executable, "-c", KILLED_WHILE_IT_WRITES, nth, moment, *arguments, "--name", f"killed{k}"],
            check=False,
        )
        assert killed.returncode == -signal.SIGKILL
        assert list(run.glob(".new-*")), "nothing was being written"

        code, _, _ = hexwar("train", "--resume", str(run))

        assert code == 0
        assert not list(run.rglob(".new-*"))
        assert weights_hash(run) == whole


def test_ctrl_c_saves_and_says_how_to_resume(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved: list[int] = []

    def save(model: QMIX, path: Path) -> None:
        saved.append(model.num_timesteps)
        save_and_press_ctrl_c(model, path)

    monkeypatch.setattr("hexwar_sb3.callbacks.checkpoint.save_checkpoint", save)

    code, out, _ = hexwar("train", *SMALL, "-n", "400", "--runs", str(tmp_path))

    assert code == 130
    assert saved == [100, 104]
    assert f"go on with: hexwar train --resume {tmp_path / 'commander_1'}" in out


def test_demonstrations_may_be_recorded_games(hexwar: Command, tmp_path: Path) -> None:
    """A folder and a bot, with weights, as the help says."""
    record_game("MA2", "MA1", seed=1).save(tmp_path / "games" / "1.hwr")
    settings = Train(demo=(str(tmp_path / "games"), "MA2=2"), n_envs=2, opponents=("MA1",))

    games = make_env(settings).unwrapped.games  # type: ignore[attr-defined]

    assert settings.learns_from_replays
    assert not Train().learns_from_replays
    assert [getattr(one, "names", one) for one in games.demonstrations.shows] == [
        ("MA2", "MA1"),
        bot_player("MA2"),
    ]
    assert "replays of people" in " ".join(hexwar("train", "--help")[1].replace("│", " ").split())


def test_a_wrong_demonstration_is_refused_before_a_run_begins(hexwar: Command, tmp_path: Path) -> None:
    bad = tmp_path / "games" / "bad.hwr"
    record_game("MA2", "MA1", seed=1).save(bad)
    bad.write_bytes(bad.read_bytes()[:-9])
    wrong = {
        str(bad.parent): f"hexwar: {bad}: byte ",
        "nobody": "hexwar: unknown bot, replay or folder 'nobody'; known: ",
        "MA2=x": "hexwar: unknown bot, replay or folder 'MA2=x'",
        "MA2=0": "hexwar: name at least one demonstration with a weight above 0",
    }
    for demo, message in wrong.items():
        code, out, err = hexwar("train", *SMALL, "--demo", demo, "--runs", str(tmp_path / "runs"))

        assert (code, out) == (2, "")
        assert err.startswith(message)
        assert err.count("\n") == 1
    assert not (tmp_path / "runs").exists()
