"""RL Baselines3 Zoo is told of our algorithms, envs and settings."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from stable_baselines3 import DQN
from stable_baselines3.common.env_util import make_vec_env

from hexwar_sb3.commands.rl_zoo import ALGORITHMS, SETTINGS, completed, register, settings_file
from hexwar_sb3.errors import ConfigError

FILES = sorted(path.stem for path in SETTINGS.glob("*.yml"))
OF_THE_ZOO = ("n_timesteps", "n_envs", "env_kwargs")  # what it takes out before the model is made


@pytest.mark.parametrize("name", FILES)
def test_a_model_is_made_of_every_settings_file(name: str) -> None:
    for env_id, settings in yaml.safe_load(settings_file(name).read_text()).items():
        env = make_vec_env(env_id, n_envs=2, env_kwargs=settings.get("env_kwargs"))
        learner: dict[str, Any] = {key: value for key, value in settings.items() if key not in OF_THE_ZOO}
        algorithm: Any = ALGORITHMS.get(name, DQN)
        model = algorithm(env=env, **{**learner, "buffer_size": 100})
        assert model.predict(env.reset())[0].shape[0] == 2


def test_every_algorithm_of_ours_has_settings() -> None:
    assert {*ALGORITHMS, "dqn"} == set(FILES)


def test_our_settings_are_taken_where_none_are_named() -> None:
    route = ["train", "--algo", "masked_dqn", "--env", "HexWarRoute-v0"]
    assert completed(route) == [*route, "--conf-file", str(settings_file("masked_dqn"))]
    for others in (
        [*route, "-conf", "mine.yml"],
        ["enjoy", *route[1:]],
        ["train", "--algo", "dqn", "--env", "CartPole-v1"],
        ["train", "--algo", "ppo", "--env", "HexWarRoute-v0"],
        ["train", "--env"],
    ):
        assert completed(others) == others


def test_without_the_zoo_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rl_zoo3.utils", None)
    with pytest.raises(ConfigError, match="pip install rl_zoo3"):
        register()


@pytest.mark.slow
def test_the_zoo_trains_saves_and_loads(tmp_path: Path) -> None:
    pytest.importorskip("rl_zoo3", reason="rl_zoo3 is not installed")
    chosen = ["--algo", "masked_dqn", "--env", "HexWarRoute-v0", "-f", str(tmp_path)]
    small = ["-n", "400", "--eval-freq", "-1", "-params", "n_envs:2", "learning_starts:100"]
    for command in (["train", *chosen, *small], ["enjoy", *chosen, "--no-render", "-n", "50"]):
        module = [sys.executable, "-W", "ignore", "-m", "hexwar_sb3.commands.rl_zoo"]
        subprocess.run([*module, *command], check=True, capture_output=True, cwd=tmp_path, timeout=500)
    assert list(tmp_path.rglob("HexWarRoute-v0.zip"))
