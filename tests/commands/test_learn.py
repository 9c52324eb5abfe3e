"""`hexwar learn`: QMIX on games of other libraries, by their names and a YAML file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
import pytest

from hexwar_sb3.algorithms.neutral import GameSettings, read_settings
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.returns import read_returns
from hexwar_sb3.cli import main
from hexwar_sb3.envs.foreign import make_joint
from hexwar_sb3.errors import ConfigError, FileFormatError
from tests.envs.test_cooperative import Tuples

GAME = "TuplesForTests-v0"
SETTINGS = """
# what differs from the defaults
n_envs: 2
team_reward: sum
last_action: true
env_kwargs: {masked: true}
learner:
  memory: gru
  n_steps: 4
  learning_starts: 40
  batch_size: 16
  train_freq: [4, step]
  learning_rate: 1.0e-3
"""


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    gymnasium.register(GAME, entry_point=cast("Any", Tuples))
    yield
    del gymnasium.registry[GAME]


@pytest.fixture
def settings(tmp_path: Path) -> Path:
    path = tmp_path / "tuples.yaml"
    path.write_text(SETTINGS)
    return path


def learn(*arguments: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main(["learn", *map(str, arguments)])
    return int(ended.value.code or 0)


def weights(model: QMIX) -> Any:
    return np.concatenate([tensor.numpy().ravel() for tensor in model.policy.agent.state_dict().values()])


def test_a_run_leaves_curve_models_and_figures(
    settings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = "--n-timesteps", 200, "--eval-freq", 100, "--eval-episodes", 4
    assert learn(GAME, "--config", settings, *flags, "--runs", tmp_path / "runs") == 0

    folder, said = tmp_path / "runs" / "learn_1", capsys.readouterr().out
    assert "best: mean return" in said
    assert [row["env_steps"] for row in read_returns(folder / "evaluations.csv")] == [0, 100, 200]
    assert (folder / "learning_curve.png").stat().st_size > 5_000
    assert json.loads((folder / "page.json").read_text())["env"] == GAME
    model = QMIX.load(folder / "best_model.zip")
    assert model.policy.memory == "gru"
    assert QMIX.load(folder / "model.zip").num_timesteps == 200
    env = make_joint(GAME, {"masked": True}, last_action=True)
    assert model.predict(env.reset(seed=0)[0], deterministic=True)[0].shape == (3,)


def test_a_run_that_was_stopped_goes_on(
    settings: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C saves; what was evaluated stays in the table."""
    train, calls = QMIX.train, []

    def stopping(model: QMIX, *arguments: Any, **more: Any) -> None:
        train(model, *arguments, **more)
        calls.append(model.num_timesteps)
        if model.num_timesteps == 120:
            import signal

            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(QMIX, "train", stopping)
    flags = "--n-timesteps", 200, "--eval-freq", 100, "--eval-episodes", 4, "--runs", tmp_path
    assert learn(GAME, "--config", settings, *flags) == 130
    folder = tmp_path / "learn_1"
    assert f"go on with: hexwar learn {GAME} --resume {folder}" in capsys.readouterr().out
    settings.unlink()

    assert learn("another:Env-v0", "--resume", folder) == 2
    assert f"is a run of the env {GAME!r}: name it before --resume" in capsys.readouterr().err

    assert learn(GAME, "--resume", folder) == 0

    assert max(calls) == 200
    assert [row["env_steps"] for row in read_returns(folder / "evaluations.csv")] == [0, 100, 200]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "which env? Gymnasium id"),
        (("no.such.module",), "there is no env 'no.such.module'"),
        (("nothing:Game-v0",), "there is no env 'nothing:Game-v0'"),
        (("json",), "json has neither parallel_env nor env"),
        (("CartPole-v1",), "JointActionEnv takes a PettingZoo env"),
        ((GAME, "--n-timesteps", 0), "n_timesteps must be at least 1, got 0"),
        ((GAME, "--config", "nowhere.yaml"), "nowhere.yaml: file: found"),
        (("--resume", "nowhere"), "config.json: file: found"),
    ],
)
def test_mistakes_are_answered_in_a_line(
    arguments: tuple[object, ...],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert learn(*arguments) != 0

    assert says in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "runs").exists()


def test_a_file_says_what_differs(settings: Path) -> None:
    found = read_settings(settings)

    assert found.joint == {
        "env_kwargs": {"masked": True},
        "team_reward": "sum",
        "privileged_state": True,
        "last_action": True,
    }
    assert found.arguments(1_000)["exploration_steps"] == 200
    assert found.arguments(1_000)["learning_rate"] == 1e-3
    assert GameSettings().arguments(1_000)["reward_scale"] is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[1, 2]", "found list; expected names and values"),
        ("a: [", "YAML of plain values"),
        ("learner: !!python/object/apply:os.system [ls]", "YAML of plain values"),
        ("a: &x [1]\nlearner: *x", "write the value out"),
        ("n_envs: 0", "n_envs|at least 1"),
        ("n_env: 3", "did you mean 'n_envs'"),
        ("team_reward: max", "unknown team_reward"),
        ("last_action: 2", "True or False"),
        ("learner: 3", "names and values"),
        ("env_kwargs: [1]", "names and values"),
        ("learner: {gama: 0.9}", "did you mean 'gamma'"),
        ("learner: {gamma: 2.0}", r"gamma must be in \[0, 1\]"),
        ("learner: {mixer: qmax}", "did you mean 'qmix'"),
        ("learner: {seed: 3}", "unknown setting"),
    ],
)
def test_a_broken_file_is_refused(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.yaml"
    path.write_text(text)

    with pytest.raises(FileFormatError, match=says):
        read_settings(path)


def test_arguments_that_a_game_does_not_take_are_told() -> None:
    with pytest.raises(ConfigError, match="env 'TuplesForTests-v0'"):
        make_joint(GAME, {"masks": True})
