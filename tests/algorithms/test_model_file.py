"""Model zips: saved and loaded, refused when broken, never unpickled without trust."""

from __future__ import annotations

import base64
import io
import json
import os
import pickle
import tracemalloc
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import safetensors.numpy
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecMonitor

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.errors import CheckpointError, ConfigError, UnknownSettingError
from hexwar_sb3.policies.task_policy import TaskPolicy

MakeEnv = Callable[..., VecMonitor]
MakeModel = Callable[..., QMIX]


class Bomb:
    """Leaves a mark when it is unpickled."""

    exploded = False

    def __reduce__(self) -> tuple[object, tuple[type[Bomb], str, bool]]:
        return setattr, (Bomb, "exploded", True)


def pickled(value: object) -> dict[str, str]:
    """A value as SB3 hides it in a zip's JSON."""
    return {":type:": "x", ":serialized:": base64.b64encode(pickle.dumps(value)).decode()}


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


def test_a_path_is_resolved_once(model: QMIX, tmp_path: Path) -> None:
    """Beside a clean `model.zip` lies `model`, the same zip with something to unpickle."""
    model.save(tmp_path / "model.zip")
    hostile = changed(tmp_path / "model.zip", zz=pickled(Bomb()))
    (tmp_path / "model").write_bytes(hostile)

    QMIX.load(tmp_path / "model")
    QMIX.load(str(tmp_path / "model"))
    QMIX.load(tmp_path / "model", trust=True)
    model.set_parameters(str(tmp_path / "model"))

    assert not Bomb.exploded


def test_what_is_read_may_change_meanwhile(
    model: QMIX, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file is opened once."""
    model.save(tmp_path / "model.zip")
    opened: list[object] = []
    read = os.open

    def note(path: Any, flags: int, *more: Any) -> int:
        opened.append(path)
        return read(path, flags, *more)

    monkeypatch.setattr(os, "open", note)

    QMIX.load(tmp_path / "model")

    assert opened == [tmp_path / "model.zip"]


WRONG: list[Any] = [{"x": 1}, [[1]], "x", "", -5, -0.5, 10**18, 1e300, None, True, pickled(0), [None] * 99]


def test_every_value_of_a_zip_is_of_its_kind_and_in_its_range(model: QMIX, tmp_path: Path) -> None:
    """Whatever one of them is changed to, it is refused by name, or it is a value that a user may give, too."""
    path = tmp_path / "model.zip"
    model.save(path)
    whole = path.read_bytes()
    names = [name for name in data_of(path) if name != "left_out"]
    taken = []
    for name in names:
        for value in WRONG:
            path.write_bytes(whole)
            path.write_bytes(changed(path, **{name: value}))
            try:
                loaded = QMIX.load(path)
            except CheckpointError as error:
                assert "data" in error.place  # noqa: PT017  # of many, one by one
            else:
                assert getattr(loaded, QMIX.attributes.get(name, name)) == value
                taken.append((name, value))
    kept = {name for name, _ in taken}
    either = {
        "seed",
        "td_lambda",
        "final_learning_rate",
        "exploration_steps",
        "leading",
        "double_q",
    }  # None, or True
    assert kept <= {*either, "learning_rate", "reward_scale", "max_grad_norm"}  # 1e300


@pytest.mark.parametrize(
    "name", ["tensorboard_log", "verbose", "predict", "device", "policy", "env", "_logger", "zz"]
)
def test_places_and_unknown_names_are_refused(model: QMIX, tmp_path: Path, name: str) -> None:
    model.save(tmp_path / "model.zip")
    (tmp_path / "model.zip").write_bytes(changed(tmp_path / "model.zip", **{name: str(tmp_path / "here")}))

    with pytest.raises(CheckpointError, match=f"data: {name}: found an unknown name"):
        QMIX.load(tmp_path / "model.zip")


def test_every_name_must_be_there_once(model: QMIX, tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    whole, text = path.read_bytes(), parts_of(path)["data"]
    for name in data_of(path):
        less = json.dumps({key: value for key, value in data_of(path).items() if key != name}).encode()
        twice = text.replace(b"{", b'{"%s": 1, ' % name.encode(), 1)
        for data in (less, twice):
            path.write_bytes(zip_of({**parts_of(path), "data": data}))
            with pytest.raises(CheckpointError, match="data"):
                QMIX.load(path)
            path.write_bytes(whole)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        '"x"'.encode("utf-16"),
        b"\xff\xfe{",
        b"",
        b"[]",
        b'{"gamma": NaN}',
        b'{"format": "hexwar model 2"}',
    ],
)
def test_data_that_are_none_are_refused_by_name(model: QMIX, tmp_path: Path, text: bytes | str) -> None:
    model.save(tmp_path / "model.zip")
    (tmp_path / "model.zip").write_bytes(zip_of({**parts_of(tmp_path / "model.zip"), "data": text}))

    with pytest.raises(CheckpointError, match=r"model.zip: data"):
        QMIX.load(tmp_path / "model.zip")


def test_a_zip_with_a_part_missing_or_too_much_is_refused(model: QMIX, tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    whole = parts_of(path)
    for name in ("data", "policy.safetensors", "policy.optimizer.safetensors"):
        path.write_bytes(zip_of({key: value for key, value in whole.items() if key != name}))
        with pytest.raises(CheckpointError, match=name.removesuffix(".safetensors")):
            QMIX.load(path)
    for name in ("leader.safetensors", "lower.policy.safetensors", "x", "../x", "policy.pth"):
        path.write_bytes(zip_of({**whole, name: whole["policy.safetensors"]}))
        with pytest.raises(CheckpointError):
            QMIX.load(path)


def spoilt(what: str, tensors: dict[str, NDArray[Any]]) -> None:
    """Change the first tensor that is no single number."""
    name = next(name for name, one in tensors.items() if one.ndim)
    one = tensors[name]
    if what in ("nan", "inf"):
        tensors[name] = np.where(np.arange(one.size).reshape(one.shape) == 0, np.float32(what), one)
    elif what in ("float64", "float16", "int32", "int64", "complex64", "bool"):
        tensors[name] = one.astype(what)
    elif what == "another shape":
        tensors[name] = one.T[..., None]
    elif what == "missing":
        del tensors[name]
    elif what == "too many":
        tensors["x"] = one


@pytest.mark.parametrize("part", ["policy", "policy.optimizer"])
@pytest.mark.parametrize(
    "what",
    [
        *("nan", "inf", "float64", "float16", "int32", "int64", "complex64", "bool"),
        *("another shape", "missing", "too many"),
    ],
)
def test_weights_are_finite_and_of_the_models_names_types_and_shapes(
    model: QMIX, tmp_path: Path, part: str, what: str
) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    parts = parts_of(path)
    tensors = {name: one.copy() for name, one in safetensors.numpy.load(parts[f"{part}.safetensors"]).items()}
    spoilt(what, tensors)
    path.write_bytes(zip_of({**parts, f"{part}.safetensors": safetensors.numpy.save(tensors)}))
    before = [weights.clone() for weights in model.policy.parameters()]

    with pytest.raises(CheckpointError, match=f"{part}.*: found"):
        QMIX.load(path)
    with pytest.raises(CheckpointError, match=f"{part}.*: found"):
        model.set_parameters(path)
    assert all(torch.equal(*pair) for pair in zip(before, model.policy.parameters(), strict=True))


def test_an_optimiser_remembers_nothing_impossible(model: QMIX, tmp_path: Path) -> None:
    """A count below 0 or a negative square: the next update would make the weights NaN."""
    path = tmp_path / "model.zip"
    model.save(path)
    parts = parts_of(path)
    for name in ("0.step", "0.exp_avg_sq"):
        tensors = dict(safetensors.numpy.load(parts["policy.optimizer.safetensors"]))
        tensors[name] = np.asarray(tensors[name] - np.float32(1e9))
        path.write_bytes(zip_of({**parts, "policy.optimizer.safetensors": safetensors.numpy.save(tensors)}))
        with pytest.raises(CheckpointError, match=r"found a number below 0"):
            QMIX.load(path)


def test_broken_bytes_are_refused_or_harmless(model: QMIX, tmp_path: Path) -> None:
    """Cut anywhere, or one byte changed: one of our errors, or the weights that were saved."""
    path = tmp_path / "model.zip"
    model.save(path)
    whole, rng = path.read_bytes(), np.random.default_rng(0)
    for k, place in enumerate(rng.integers(len(whole), size=60).tolist()):
        broken = whole[:place] if k % 2 else whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :]
        path.write_bytes(broken)
        try:
            loaded = QMIX.load(path)
        except CheckpointError:
            continue
        torch.testing.assert_close(loaded.policy.state_dict(), model.policy.state_dict(), rtol=0, atol=0)


def test_numbers_are_checked_before_memory_is_taken(model: QMIX, tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    whole, sizes = path.read_bytes(), data_of(path)["task_sizes"]
    greedy: list[dict[str, Any]] = [
        {"buffer_size": 10**12},
        {"buffer_size": 10**7},
        *({"task_sizes": {**sizes, name: size}} for name in sizes for size in (10**9, 10**18, 1_000, 4_000)),
        {"policy_kwargs": {"hidden": 4_096, "embed": 4_096}},
        {"policy_kwargs": {"mixer": "qmix", "state_dim": 1 << 20, "mixer_kwargs": {"embed": 4_096}}},
    ]
    for change in greedy:
        path.write_bytes(whole)
        file = io.BytesIO(changed(path, **change))
        tracemalloc.start()
        with suppress(CheckpointError):
            QMIX.load(file)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 1 << 25, change


def test_a_zip_of_an_earlier_version_is_refused_by_name_and_read_with_trust(
    model: QMIX, make_env: MakeEnv, tmp_path: Path
) -> None:
    """As SB3's own `save` writes it."""
    path = tmp_path / "old.zip"
    save_as_before(model, path)

    with pytest.raises(CheckpointError, match=r"pickled ones, of an earlier version.*trust=True"):
        QMIX.load(path)
    for env in (None, make_env(2), make_env(2, with_state=False)):
        loaded = QMIX.load(path, env=env, trust=True)
        torch.testing.assert_close(loaded.policy.state_dict(), model.policy.state_dict(), rtol=0, atol=0)
        assert (loaded.reward_scale, loaded.num_timesteps) == (7.0, model.num_timesteps)
        moments = (one.policy.optimizer.state_dict()["state"] for one in (loaded, model))
        torch.testing.assert_close(*moments, rtol=0, atol=0)
    loaded.save(tmp_path / "new.zip")
    QMIX.load(tmp_path / "new.zip")


def test_with_trust_a_broken_pickle_is_one_of_our_errors(model: QMIX, tmp_path: Path) -> None:
    path = tmp_path / "old.zip"
    save_as_before(model, path)
    parts = parts_of(path)
    for name in ("data", "policy.pth", "policy.optimizer.pth"):
        path.write_bytes(zip_of({**parts, name: b"\x80\x04broken"}))
        with pytest.raises(CheckpointError, match=r"old\.zip"):
            QMIX.load(path, trust=True)


def test_a_learning_rate_that_is_a_function_is_left_out_and_wanted_back(
    make_model: MakeModel, tmp_path: Path
) -> None:
    model = make_model(learning_rate=lambda left: 1e-3 * left)
    with pytest.warns(UserWarning, match=r"learning_rate cannot be saved.*QMIX.load\(path, custom_objects="):
        model.save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match=r"data: learning_rate: found nothing; expected custom_objects"):
        QMIX.load(tmp_path / "model.zip")
    again = {"learning_rate": lambda left: 2e-3 * left}
    assert QMIX.load(tmp_path / "model.zip", custom_objects=again).lr_schedule(0.5) == pytest.approx(1e-3)
    assert QMIX.load(tmp_path / "model.zip", learning_rate=0.1).learning_rate == 0.1


def test_a_policy_class_of_ones_own_is_wanted_back(make_env: MakeEnv, tmp_path: Path) -> None:
    class Own(TaskPolicy):
        def __init__(self, *args: Any, note: str = "", **options: Any) -> None:
            super().__init__(*args, **options)
            self.note = note

    model = QMIX(Own, make_env(), buffer_size=40, policy_kwargs={"note": "mine"})
    with pytest.warns(UserWarning, match="policy_class cannot be saved"):
        model.save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match="data: policy_class: found nothing"):
        QMIX.load(tmp_path / "model.zip")
    assert cast("Own", QMIX.load(tmp_path / "model.zip", policy_class=Own).policy).note == "mine"


def test_the_callers_values_win_before_the_zips_are_refused(
    model: QMIX, make_env: MakeEnv, tmp_path: Path
) -> None:
    """As rl-zoo loads a model to play with it."""
    path = tmp_path / "model.zip"
    model.save(path)
    path.write_bytes(changed(path, learning_rate=pickled(Bomb()), buffer_size=10**12, gamma="x"))
    custom = {"learning_rate": 0.0, "lr_schedule": lambda _: 0.0, "clip_range": lambda _: 0.0, "gamma": 0.5}

    loaded = QMIX.load(path, env=make_env(2), custom_objects=custom, device="cpu", seed=0, buffer_size=1)

    assert (loaded.learning_rate, loaded.gamma, loaded.buffer_size, loaded.seed) == (0.0, 0.5, 1, 0)
    assert not Bomb.exploded
    loaded.save(path)
    assert QMIX.load(path).learning_rate == 0.0
    assert QMIX.load(
        path, train_freq=4, mixer="qmix", stats_window_size=5, tensorboard_log="x"
    ).update_every == (4, "step")


def test_an_argument_of_load_that_means_nothing_is_refused(model: QMIX, tmp_path: Path) -> None:
    model.save(tmp_path / "model.zip")

    with pytest.raises(
        UnknownSettingError, match=r"unexpected keyword argument 'gama'.*did you mean 'gamma'"
    ):
        QMIX.load(tmp_path / "model.zip", gama=0.5)
    with pytest.raises(ConfigError, match=r"gamma must be in \[0, 1\], got 2.0"):
        QMIX.load(tmp_path / "model.zip", gamma=2.0)


def test_what_others_leave_on_a_model_is_not_saved(model: QMIX, tmp_path: Path) -> None:
    model.best = lambda: 0  # type: ignore[attr-defined]
    model.notes = {"x": Path()}  # type: ignore[attr-defined]
    model.save(tmp_path / "model.zip", exclude=["replay_buffer"], include=["notes"])

    assert not {"best", "notes"} & set(vars(QMIX.load(tmp_path / "model.zip")))


MENDED: dict[str, tuple[Any, Any]] = {
    "batch_size": (np.int64(16), 16),
    "buffer_size": (400.0, 400),
    "learning_starts": (np.float64(20.0), 20),
    "gamma": (np.float32(0.5), 0.5),
    "tau": (np.array(0.25), 0.25),
    "learning_rate": (np.float32(0.5), 0.5),
    "double_q": (np.bool_(False), False),
    "loss": (np.str_("huber"), "huber"),
    "seed": (np.uint32(7), 7),
    "train_freq": (np.int32(4), (4, "step")),
    "td_lambda": (1, 1.0),
    "policy_kwargs": ({"hidden": np.int16(8), "mixer": "vdn"}, {"hidden": 8, "mixer": "vdn", "state_dim": 6}),
}


def test_what_can_be_trained_with_can_be_saved_and_loaded(make_model: MakeModel, tmp_path: Path) -> None:
    """Plain values are made of those of numpy when the model is made."""
    model = make_model(**{name: given for name, (given, _) in MENDED.items()}).learn(60)
    model.save(tmp_path / "model.zip")

    for one in (model, QMIX.load(tmp_path / "model.zip")):
        for name, (_, expected) in MENDED.items():
            found = getattr(one, QMIX.attributes.get(name, name))
            assert (type(found), found) == (type(expected), expected)


@pytest.mark.parametrize(
    "path",
    ["", ".", "missing", "folder", "fifo.zip", "nul\0.zip", "x" * 5_000],
    ids=lambda path: repr(path[:9]),
)
def test_what_is_no_file_is_refused(
    make_model: MakeModel, tmp_path: Path, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.zip").mkdir()
    os.mkfifo(tmp_path / "fifo.zip")

    with pytest.raises(CheckpointError, match="expected a model zip"):
        QMIX.load(path)
    with pytest.raises(CheckpointError, match="expected a replay"):
        make_model().load_replay_buffer(path or "folder.zip")


@pytest.mark.parametrize("file", [io.StringIO("x"), io.BytesIO(b""), io.BytesIO(b"PK")])
def test_an_open_file_that_is_no_model_is_refused(file: Any) -> None:
    with pytest.raises(CheckpointError, match="model: file"):
        QMIX.load(file)


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04 broken"])
def test_a_broken_file_is_refused_by_name(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.zip").write_bytes(content)

    with pytest.raises(CheckpointError, match=r"model.zip: file: found .*; expected a model zip"):
        QMIX.load(tmp_path / "model.zip")


def test_a_zip_of_another_algorithm_is_refused(tmp_path: Path) -> None:
    PPO("MlpPolicy", "CartPole-v1", device="cpu").save(tmp_path / "ppo.zip")

    with pytest.raises(CheckpointError, match="pickled ones, of an earlier version or of Stable-Baselines3"):
        QMIX.load(tmp_path / "ppo.zip")
    with pytest.raises(ConfigError, match="a task env has Dict observations"):
        QMIX.load(tmp_path / "ppo.zip", trust=True)


def test_a_broken_replay_is_one_of_our_errors(model: QMIX, make_model: MakeModel, tmp_path: Path) -> None:
    path = tmp_path / "replay.npz"
    model.save_replay_buffer(path)
    whole = path.read_bytes()
    contents = [
        b"",
        whole[:100],
        whole[: len(whole) // 2],
        pickle.dumps(Bomb()),
        zip_of({"x.npy": b"x"}),
        zip_of({}),
    ]
    other = make_model()
    for content in contents:
        path.write_bytes(content)
        for file in (path, str(path), io.BytesIO(content)):
            with pytest.raises(CheckpointError):
                other.load_replay_buffer(file)
    assert not Bomb.exploded


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


def parts_of(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def data_of(path: Path) -> dict[str, Any]:
    return cast("dict[str, Any]", json.loads(parts_of(path)["data"]))


def zip_of(parts: dict[str, Any]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return file.getvalue()


def changed(path: Path, **values: Any) -> bytes:
    """The zip with other values."""
    return zip_of({**parts_of(path), "data": json.dumps({**data_of(path), **values}).encode()})


def save_as_before(model: QMIX, path: Path) -> None:
    """Write a zip as SB3 and earlier versions did, with pickled spaces and weights."""
    again = ["lr_schedule", "train_freq", "rng", "explorer", "current", "game_log", "learner", "_learns"]
    OffPolicyAlgorithm.save(model, path, exclude=[*again, "_last_obs", "_eval_envs", "_leading"])
