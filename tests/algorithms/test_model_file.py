"""Model zips: saved and loaded, refused when broken, never unpickled without trust."""

from __future__ import annotations

import base64
import io
import json
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import CheckpointError, ConfigError

MakeEnv = Callable[..., VecMonitor]
MakeModel = Callable[..., QMIX]


class Bomb:
    """Leaves a mark when it is unpickled."""

    exploded = False

    def __reduce__(self) -> tuple[object, tuple[type[Bomb], str, bool]]:
        return setattr, (Bomb, "exploded", True)


@pytest.fixture
def model(make_model: MakeModel) -> QMIX:
    return make_model(exploration_episodes=100, reward_scale=7.0).learn(160)


def test_a_model_without_an_env_says_how_to_get_one(model: QMIX, tmp_path: Path) -> None:
    model.save(tmp_path / "model.zip")

    with pytest.raises(ConfigError, match=r"no env to learn in: QMIX.load\(path, env=env\)"):
        QMIX.load(tmp_path / "model.zip").learn(10)


def test_a_loaded_model_predicts_the_same(make_env: MakeEnv, model: QMIX, tmp_path: Path) -> None:
    model.save(tmp_path / "model")
    observation = cast("dict[str, NDArray[np.float32]]", make_env(8, with_state=False).reset())

    loaded = QMIX.load(tmp_path / "model.zip")

    assert (
        loaded.predict(observation, deterministic=True)[0]
        == model.predict(observation, deterministic=True)[0]
    ).all()


def test_counters_settings_targets_and_optimiser_come_back(make_env: MakeEnv, model: QMIX) -> None:
    file = io.BytesIO()
    model.save(file)

    loaded = QMIX.load(file, env=make_env(2))

    assert loaded.reward_scale == 7.0
    assert loaded.exploration_rate == model.exploration_rate
    assert (loaded._n_updates, loaded.num_timesteps) == (model._n_updates, model.num_timesteps)
    torch.testing.assert_close(loaded.policy.state_dict(), model.policy.state_dict(), rtol=0, atol=0)
    torch.testing.assert_close(loaded.policy.optimizer.state_dict(), model.policy.optimizer.state_dict())
    loaded.learn(40, reset_num_timesteps=False)


def test_a_model_trained_with_the_state_loads_on_an_env_without_it(
    make_env: MakeEnv, model: QMIX, tmp_path: Path
) -> None:
    model.save(tmp_path / "model.zip")

    loaded = QMIX.load(tmp_path / "model.zip", env=make_env(2, with_state=False))

    with pytest.raises(ConfigError, match="trained on a state of 6 numbers, the env gives 15"):
        loaded.learn(10)


def test_an_env_of_other_sizes_is_refused(make_env: MakeEnv, model: QMIX, tmp_path: Path) -> None:
    model.save(tmp_path / "model.zip")
    env = make_env(2)
    env.action_space = type(env.action_space)([5, 5, 5])

    with pytest.raises(ConfigError, match=r"actions must be MultiDiscrete\(\[4, 4, 4\]\)"):
        QMIX.load(tmp_path / "model.zip", env=env)


def test_nothing_is_unpickled_without_trust(model: QMIX, tmp_path: Path) -> None:
    model.save(tmp_path / "model.zip")
    swap(tmp_path / "model.zip", "gamma", Bomb())

    with pytest.raises(CheckpointError, match=r"pickled values \['gamma'\].*trust=True"):
        QMIX.load(tmp_path / "model.zip")
    assert not Bomb.exploded


@pytest.mark.parametrize("name", ["policy_class", "observation_space", "action_space"])
def test_what_is_made_again_is_not_unpickled_either(model: QMIX, tmp_path: Path, name: str) -> None:
    model.save(tmp_path / "model.zip")
    swap(tmp_path / "model.zip", name, Bomb())

    QMIX.load(tmp_path / "model.zip")

    assert not Bomb.exploded


def test_a_learning_rate_that_is_a_function_needs_trust(make_model: MakeModel, tmp_path: Path) -> None:
    make_model(learning_rate=lambda left: 1e-3 * left).save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match=r"pickled values \['learning_rate'\]"):
        QMIX.load(tmp_path / "model.zip")
    assert QMIX.load(tmp_path / "model.zip", trust=True).lr_schedule(0.5) == pytest.approx(5e-4)


def test_a_zip_of_another_algorithm_is_refused(tmp_path: Path) -> None:
    PPO("MlpPolicy", "CartPole-v1", device="cpu").save(tmp_path / "ppo.zip")

    with pytest.raises(CheckpointError, match="found no task_sizes; expected a zip of ours, or trust=True"):
        QMIX.load(tmp_path / "ppo.zip")


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04 broken"])
def test_a_broken_file_is_refused_by_name(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.zip").write_bytes(content)

    with pytest.raises(CheckpointError, match=r"model.zip: file: found .*; expected a model zip"):
        QMIX.load(tmp_path / "model.zip")


def test_data_nested_without_end_are_refused_by_name(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "model.zip", "w") as archive:
        archive.writestr("data", "[" * 100_000)

    with pytest.raises(CheckpointError, match=r"model.zip: file: found maximum recursion depth"):
        QMIX.load(tmp_path / "model.zip")


def test_a_save_that_fails_leaves_the_old_file(
    model: QMIX, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk or a kill in the middle of saving."""
    path = tmp_path / "model.zip"
    model.save(path)
    before = path.read_bytes()
    monkeypatch.setattr(Path, "write_bytes", fail)

    with pytest.raises(OSError, match="no space left"):
        model.save(path)

    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["model.zip"]


def test_a_replay_comes_back_without_its_running_games(
    model: QMIX, make_model: MakeModel, tmp_path: Path
) -> None:
    model.save_replay_buffer(tmp_path / "replay.npz")
    other = make_model()

    other.load_replay_buffer(tmp_path / "replay.npz")

    assert len(other.replay_buffer) == len(model.replay_buffer) == 160
    assert other.replay_buffer.done.sum() == model.replay_buffer.done.sum() + 4
    other.learn(60)


def fail(*_: object) -> None:
    raise OSError("no space left")


def swap(path: Path, name: str, value: object) -> None:
    """Put a pickled value into a model zip."""
    with zipfile.ZipFile(path) as archive:
        parts = {part: archive.read(part) for part in archive.namelist()}
    data = json.loads(parts["data"])
    data[name] = {":type:": "x", ":serialized:": base64.b64encode(pickle.dumps(value)).decode()}
    parts["data"] = json.dumps(data).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for part, content in parts.items():
            archive.writestr(part, content)
