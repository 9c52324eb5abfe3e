"""FrozenPolicy: equal to torch, the same in any batch, and a folder that is checked before it is used."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import safetensors.numpy
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, HexWarError, PolicyFileError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import FrozenLower, fastest_way_network
from hexwar_sb3.players.player import make_player
from hexwar_sb3.policies.task_policy import TaskPolicy

PIECES, TASKS, OBS, TASK = 3, 6, 9, 4

Obs = dict[str, NDArray[Any]]


@pytest.fixture(scope="module")
def policy() -> TaskPolicy:
    space = spaces.Dict(
        {
            "obs": spaces.Box(-1.0, 1.0, (PIECES, OBS)),
            "tasks": spaces.Box(-1.0, 1.0, (PIECES, TASKS, TASK)),
            "action_mask": spaces.Box(0, 1, (PIECES, TASKS), np.int8),
            "alive": spaces.Box(0.0, 1.0, (PIECES,)),
        }
    )
    return TaskPolicy(space, spaces.MultiDiscrete([TASKS] * PIECES), lambda _: 1e-3)


@pytest.fixture
def folder(policy: TaskPolicy, tmp_path: Path) -> Path:
    policy.freeze(rules="abc", scenario="plain").save(tmp_path / "policy")
    return tmp_path / "policy"


def observe(games: int = 20) -> Obs:
    rng = np.random.default_rng(0)
    mask = (rng.random((games, PIECES, TASKS)) < 0.5).astype(np.int8)
    mask[..., 0] = 1
    return {
        "obs": rng.standard_normal((games, PIECES, OBS), np.float32),
        "tasks": rng.standard_normal((games, PIECES, TASKS, TASK), np.float32),
        "action_mask": mask,
        "alive": np.ones((games, PIECES), np.float32),
    }


def test_values_and_tasks_equal_those_of_torch(policy: TaskPolicy) -> None:
    obs, frozen = observe(), policy.freeze()
    tensors, _ = policy.obs_to_tensor(obs)

    q = policy.agent(*(tensors[key] for key in ("obs", "tasks", "action_mask"))).detach().numpy()  # type: ignore[index]

    np.testing.assert_allclose(frozen.q_values(obs), q, atol=1e-5)
    assert (frozen.act(obs) == policy.predict(obs)[0]).all()


def test_a_game_alone_and_in_a_batch_has_the_same_values_to_the_bit(policy: TaskPolicy) -> None:
    obs, frozen = observe(), policy.freeze()
    batch = frozen.q_values(obs)

    for game in range(3):
        alone = {key: value[game : game + 1] for key, value in obs.items()}
        assert (frozen.q_values(alone)[0] == batch[game]).all()


def test_half_precision_and_single_observations_are_taken(policy: TaskPolicy) -> None:
    obs, frozen = observe(), policy.freeze()
    half = {
        key: value.astype(np.float16) if value.dtype == np.float32 else value for key, value in obs.items()
    }

    assert frozen.act(half).shape == (20, PIECES)
    single, _ = frozen.predict({key: value[0] for key, value in obs.items()})
    assert (single == frozen.act(obs)[0]).all()


def test_it_comes_back_from_its_folder(policy: TaskPolicy, folder: Path) -> None:
    loaded = FrozenPolicy.load(folder, rules="abc")

    assert loaded.about == {"rules": "abc", "scenario": "plain"}
    assert (loaded.q_values(observe()) == policy.freeze().q_values(observe())).all()
    assert sorted(path.name for path in folder.iterdir()) == ["config.json", "weights.safetensors"]


def test_rules_that_it_was_not_trained_under_are_refused(folder: Path) -> None:
    with pytest.raises(
        PolicyFileError, match=r"about.rules: found 'abc'; expected 'xyz', the rules of this game"
    ):
        FrozenPolicy.load(folder, rules="xyz")


def test_an_observation_of_other_sizes_is_refused(policy: TaskPolicy) -> None:
    obs = observe()
    obs["obs"] = obs["obs"][..., :-1]

    with pytest.raises(ConfigError, match=r"\(3, 6, 9, 4\), got \(3, 6, 8, 4\)"):
        policy.freeze().act(obs)


def change(key: str, value: object) -> Callable[[Path], None]:
    """Change one entry of config.json."""

    def act(folder: Path) -> None:
        config = json.loads((folder / "config.json").read_text())
        config[key] = value
        (folder / "config.json").write_text(json.dumps(config))

    return act


def write(name: str, content: bytes) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_bytes(content)


SIZES = {"obs": OBS, "task": TASK, "hidden": 64, "embed": 32, "one": 1}


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (
            write("config.json", b"{"),
            "config.json: text, line 1, column 2: found .*; expected a policy's config as JSON",
        ),
        (write("config.json", b"[" * 60_000), "config.json: text: found maximum recursion depth"),
        (write("config.json", b"[]"), "config.json: file: found list; expected a policy's config"),
        (
            write("config.json", b" " * 70_000),
            "config.json: file size: found more than 65536 bytes; expected at most 65536",
        ),
        (change("version", 9), "expected 'hexwar task policy', version 1"),
        (change("n_pieces", 0), "config.json: n_pieces: found 0; expected a whole number from 1 to 4096"),
        (change("n_tasks", 10**9), "n_tasks: found 1000000000; expected a whole number from 1 to 4096"),
        (change("n_tasks", True), "n_tasks: found True"),
        (change("sizes", {"obs": 1}), "config.json: sizes: found {'obs': 1}; expected the axes"),
        (
            change("sizes", {**SIZES, "hidden": 63}),
            r"piece.weight has the shape \(64, 9\), expected \(63, 9\)",
        ),
        (change("about", [1]), r"config.json: about: found \[1\]; expected texts by name"),
        (change("weights_sha256", "0"), "weights.safetensors: sha256: found other weights"),
        (write("weights.safetensors", b""), "weights.safetensors: sha256: found other weights"),
        (
            write("weights.safetensors", b"\0" * (1 << 24) + b"\0"),
            "weights.safetensors: file size: found more than 16777216 bytes; expected at most 16777216",
        ),
        (
            lambda folder: (folder / "weights.safetensors").unlink(),
            "weights.safetensors: file: found .*No such file",
        ),
        (lambda folder: (folder / "config.json").unlink(), "config.json: file: found .*No such file"),
    ],
)
def test_a_damaged_folder_is_refused_with_file_and_place(
    folder: Path, damage: Callable[[Path], object], message: str
) -> None:
    damage(folder)

    with pytest.raises(PolicyFileError, match=message):
        FrozenPolicy.load(folder)


def rewrite(folder: Path, weights: dict[str, NDArray[np.float32]]) -> None:
    """Put other weights there, with a config that vouches for them."""
    import hashlib

    data = safetensors.numpy.save(weights)
    (folder / "weights.safetensors").write_bytes(data)
    change("weights_sha256", hashlib.sha256(data).hexdigest())(folder)


@pytest.mark.parametrize(
    ("name", "array", "message"),
    [
        ("piece.bias", np.full(64, np.nan, np.float32), "piece.bias holds numbers that are not finite"),
        ("piece.bias", np.zeros(63, np.float32), r"piece.bias has the shape \(63,\), expected \(64,\)"),
        ("extra", np.zeros(1, np.float32), "arrays: found .*'extra'"),
    ],
)
def test_weights_that_cannot_be_right_are_refused(
    folder: Path, name: str, array: NDArray[np.float32], message: str
) -> None:
    weights = safetensors.numpy.load_file(folder / "weights.safetensors")

    rewrite(folder, {**weights, name: array})

    with pytest.raises(PolicyFileError, match=message):
        FrozenPolicy.load(folder)


def test_a_pickle_in_place_of_the_weights_is_not_run(folder: Path) -> None:
    import hashlib
    import pickle

    data = pickle.dumps({"piece.weight": 1})
    (folder / "weights.safetensors").write_bytes(data)
    change("weights_sha256", hashlib.sha256(data).hexdigest())(folder)

    with pytest.raises(PolicyFileError, match="expected safetensors"):
        FrozenPolicy.load(folder)


def test_a_policy_trained_under_other_rules_is_not_seated(folder: Path) -> None:
    with pytest.raises(
        PolicyFileError, match=r"config.json: about.rules: found 'abc'; expected '[0-9a-f]{64}'"
    ):
        make_player(folder)


def test_a_policy_that_names_no_rules_may_play_by_any(policy: TaskPolicy, tmp_path: Path) -> None:
    policy.freeze().save(tmp_path / "unnamed")
    assert isinstance(make_player(tmp_path / "unnamed"), FrozenPolicy)


# --- a stranger's folder -------------------------------------------------------------------------


def sealed(folder: Path, data: bytes) -> None:
    """Put these bytes in place of the weights, with a config that vouches for them."""
    import hashlib

    (folder / "weights.safetensors").write_bytes(data)
    change("weights_sha256", hashlib.sha256(data).hexdigest())(folder)


def with_header(folder: Path, header: bytes) -> bytes:
    """The weights' bytes under another header."""
    data = (folder / "weights.safetensors").read_bytes()
    return len(header).to_bytes(8, "little") + header + data[8 + int.from_bytes(data[:8], "little") :]


def header_of(folder: Path) -> dict[str, Any]:
    data = (folder / "weights.safetensors").read_bytes()
    return dict(json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")]))


def test_nothing_but_our_errors_comes_of_a_bad_config(folder: Path, bad: Any) -> None:
    config = json.loads((folder / "config.json").read_text())
    refused = 0
    for content in bad(config):
        (folder / "config.json").write_bytes(content)
        try:
            FrozenPolicy.load(folder)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 100


def test_nothing_but_our_errors_comes_of_a_bad_header(folder: Path, bad: Any) -> None:
    header = header_of(folder)
    start = {"piece.bias": header["piece.bias"], **header}
    refused = 0
    whole = (folder / "weights.safetensors").read_bytes()
    for content in islice(bad(start), 0, None, 2):
        (folder / "weights.safetensors").write_bytes(whole)
        sealed(folder, with_header(folder, content))
        try:
            FrozenPolicy.load(folder)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 100


@pytest.mark.parametrize("dtype", ["I32", "F64", "F16", "BF16", "C64", "U8", "", None, ["F32"]])
def test_weights_declared_as_anything_but_32_bit_floats_are_refused(folder: Path, dtype: object) -> None:
    header = header_of(folder)
    header["piece.bias"]["dtype"] = dtype
    sealed(folder, with_header(folder, json.dumps(header).encode()))
    with pytest.raises(PolicyFileError, match=r"piece\.bias: found dtype .*; expected 'F32'"):
        FrozenPolicy.load(folder)


def test_an_array_twice_is_refused_and_further_words_are_not(folder: Path) -> None:
    text = json.dumps(header_of(folder))
    worded = text.replace("{", '{"__metadata__": {"made": "here"}, ', 1)
    sealed(folder, with_header(folder, worded.encode()))
    assert FrozenPolicy.load(folder).n_pieces == PIECES
    twice = text[:-1] + ', "piece.bias": ' + json.dumps(header_of(folder)["piece.bias"]) + "}"
    sealed(folder, with_header(folder, twice.encode()))
    with pytest.raises(PolicyFileError, match=r"header: found the key 'piece\.bias' twice"):
        FrozenPolicy.load(folder)


def test_a_key_twice_in_the_config_is_refused(folder: Path) -> None:
    text = (folder / "config.json").read_text()
    (folder / "config.json").write_text(text.replace("{", '{"version": 1, ', 1))
    with pytest.raises(PolicyFileError, match="the key 'version' twice"):
        FrozenPolicy.load(folder)


FORMS: dict[str, Callable[[NDArray[np.float32]], NDArray[Any]]] = {
    "another memory order": np.asfortranarray,
    "a view": lambda array: np.repeat(array, 2, axis=-1)[..., ::2],
    "another byte order": lambda array: array.astype(">f4"),
    "64 bits": lambda array: array.astype(np.float64),
    "backwards": lambda array: array[::-1].copy()[::-1],
}


@pytest.mark.parametrize("form", FORMS)
def test_weights_in_any_form_come_back_as_they_play(form: str, policy: TaskPolicy, tmp_path: Path) -> None:
    """Safetensors writes the bytes as they lie, whatever order they are in."""
    frozen, obs = policy.freeze(), observe()
    weights = {name: FORMS[form](array) for name, array in frozen.weights.items()}
    other = FrozenPolicy(weights, n_pieces=PIECES, n_tasks=TASKS)
    other.save(tmp_path / "saved")
    other.weights["embed.weight"] = np.asfortranarray(other.weights["embed.weight"])  # after it was made, too
    other.save(tmp_path / "again")
    for name in ("saved", "again"):
        loaded = FrozenPolicy.load(tmp_path / name)
        assert loaded.sha256 == frozen.sha256
        assert (loaded.act(obs) == frozen.act(obs)).all()


@pytest.mark.parametrize("value", [1j, np.nan, np.inf, 1e300, "x", None])
def test_weights_that_are_no_real_numbers_are_refused_when_a_policy_is_made(
    policy: TaskPolicy, value: Any
) -> None:
    weights = {**policy.freeze().weights, "piece.bias": np.full(64, value)}
    with pytest.raises(ConfigError, match=r"piece\.bias holds"):
        FrozenPolicy(weights, n_pieces=PIECES, n_tasks=TASKS)


@pytest.fixture
def led(policy: TaskPolicy, tmp_path: Path) -> Path:
    """Folder of a policy with a lower level of its own."""
    policy.freeze(rules="abc").led_by(fastest_way_network()).save(tmp_path / "led")
    return tmp_path / "led"


def instead(make: Callable[[Path], object]) -> Callable[[Path], None]:
    """Put something else in the folder's place."""

    def act(lower: Path) -> None:
        shutil.rmtree(lower)
        make(lower)

    return act


LOWERS: dict[str, Callable[[Path], object]] = {
    "no config": lambda lower: (lower / "config.json").unlink(),
    "no weights": lambda lower: (lower / "weights.safetensors").unlink(),
    "gone": shutil.rmtree,
    "a file": instead(Path.touch),
    "a broken link": instead(lambda lower: lower.symlink_to("nowhere")),
    "a link to itself": instead(lambda lower: lower.symlink_to(lower)),
}


@pytest.mark.parametrize("says", ["new", "old"])
@pytest.mark.parametrize("what", LOWERS)
def test_a_lower_level_of_which_a_part_is_gone_is_refused(what: str, says: str, led: Path) -> None:
    """The heuristic does not play in its place; older folders do not say that they have one."""
    if says == "old":
        config = json.loads((led / "config.json").read_text())
        del config["lower"]
        (led / "config.json").write_text(json.dumps(config))
        assert isinstance(FrozenPolicy.load(led).lower, FrozenLower)
    LOWERS[what](led / "lower")
    if says == "old" and what == "gone":
        assert FrozenPolicy.load(led).lower == "heuristic"
        return
    with pytest.raises(PolicyFileError):
        FrozenPolicy.load(led)


def test_a_lower_level_that_the_config_does_not_know_is_refused(led: Path) -> None:
    change("lower", False)(led)
    with pytest.raises(PolicyFileError, match="found a lower level; expected none"):
        FrozenPolicy.load(led)
    strange: tuple[object, ...] = (None, 1, "yes", [])
    for value in strange:
        change("lower", value)(led)
        with pytest.raises(PolicyFileError, match="expected true or false"):
            FrozenPolicy.load(led)


def test_a_policy_without_a_lower_level_says_so(folder: Path) -> None:
    assert json.loads((folder / "config.json").read_text())["lower"] is False
    assert FrozenPolicy.load(folder).lower == "heuristic"


@pytest.mark.parametrize("name", ["config.json", "weights.safetensors"])
def test_a_pipe_or_a_device_is_not_read(folder: Path, name: str) -> None:
    for make in (os.mkfifo, lambda path: path.symlink_to("/dev/zero"), lambda path: path.symlink_to(path)):
        (folder / name).unlink(missing_ok=True)
        make(folder / name)
        with pytest.raises(PolicyFileError):
            FrozenPolicy.load(folder)
