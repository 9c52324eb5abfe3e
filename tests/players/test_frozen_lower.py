"""Lower levels by name, folder and object: a network comes back from its folder, and nothing else is taken for one."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import safetensors.numpy
import torch
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
from hexwar_sb3.envs.route_vec_env import route_spaces
from hexwar_sb3.errors import ConfigError, PolicyFileError, UnknownNameError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import (
    FEATURES,
    FORMAT,
    HEURISTIC_LOWER,
    SIZES,
    FrozenLower,
    check_answers,
    make_lower,
)
from hexwar_sb3.players.player import make_player
from hexwar_sb3.policies.masked import MaskedDQNPolicy, freeze_lower
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.tasks.features import ROUTE_WIDTH
from hexwar_sb3.tasks.route import N_ANSWERS

CONFIG, WEIGHTS = "config.json", "weights.safetensors"
Arrays = dict[str, NDArray[np.float32]]


def random_weights(seed: int = 0, **sizes: int) -> Arrays:
    """Weights of these sizes, else of the right ones."""
    rng, known = np.random.default_rng(seed), {**SIZES, **sizes}
    return {
        name: rng.normal(size=[known[axis] for axis in axes]).astype(np.float32)
        for name, axes in FORMAT.layers.items()
    }


def random_states(n: int = 50) -> NDArray[np.float32]:
    return np.random.default_rng(1).normal(size=(n, ROUTE_WIDTH)).astype(np.float32)


@pytest.fixture
def lower() -> FrozenLower:
    return FrozenLower(random_weights(), ways=False, tie=0.01, about={"scenario": "plain"})


@pytest.fixture
def folder(lower: FrozenLower, tmp_path: Path) -> Path:
    lower.save(tmp_path / "lower")
    return tmp_path / "lower"


@pytest.fixture(scope="module")
def policy() -> FrozenPolicy:
    """A small policy of the task level."""
    torch.manual_seed(0)
    space = spaces.Dict(
        {
            "obs": spaces.Box(-1.0, 1.0, (3, 9)),
            "tasks": spaces.Box(-1.0, 1.0, (3, 6, 4)),
            "action_mask": spaces.Box(0, 1, (3, 6), np.int8),
            "alive": spaces.Box(0.0, 1.0, (3,)),
        }
    )
    return TaskPolicy(space, spaces.MultiDiscrete([6] * 3), lambda _: 1e-3).freeze()


def with_lower(policy: FrozenPolicy, lower: Any) -> FrozenPolicy:
    return FrozenPolicy(policy.weights, n_pieces=3, n_tasks=6, lower=lower)


def same(one: FrozenLower, other: object) -> bool:
    assert isinstance(other, FrozenLower)
    alike = [np.array_equal(one.weights[name], other.weights[name]) for name in FORMAT.layers]
    return (one.ways, one.tie) == (other.ways, other.tie) and all(alike)


def test_it_comes_back_from_its_folder(lower: FrozenLower, folder: Path) -> None:
    loaded = FrozenLower.load(folder)

    assert same(lower, loaded)
    assert (loaded.q_values(random_states()) == lower.q_values(random_states())).all()
    assert loaded.about == {"scenario": "plain", "features": FEATURES, "ways": "no", "tie": "0.01"}
    assert sorted(path.name for path in folder.iterdir()) == [CONFIG, WEIGHTS]


@pytest.mark.parametrize(("tie", "answer"), [(0.0, 3), (0.05, 3), (0.15, 2), (0.35, 1), (9.0, 1)])
def test_of_values_that_are_nearer_than_a_tie_the_first_valid_one_counts(tie: float, answer: int) -> None:
    weights = {name: np.zeros_like(array) for name, array in random_weights().items()}
    weights["layer3.bias"][:] = [2.0, 0.7, 0.9, 1.0, 0.98, 0.0, 1.0]
    mask = np.array([[0, 1, 1, 1, 1, 1, 1]], np.int8)

    assert FrozenLower(weights, tie=tie)(random_states()[:1], mask).tolist() == [answer]


@pytest.mark.parametrize("tie", [-0.1, float("inf"), float("nan")])
def test_a_tie_out_of_range_is_refused(tie: float) -> None:
    with pytest.raises(ConfigError, match="tie must be finite and at least 0"):
        FrozenLower(random_weights(), tie=tie)


def test_a_value_does_not_depend_on_the_batch(lower: FrozenLower) -> None:
    """The same to the bit, alone and among others."""
    batch = lower.q_values(random_states())
    for k in range(5):
        assert (lower.q_values(random_states()[k : k + 1])[0] == batch[k]).all()


def change(key: str, value: object) -> Callable[[Path], None]:
    """Change one entry of config.json; "about.x" is one of its texts."""

    def act(folder: Path) -> None:
        config = json.loads((folder / CONFIG).read_text())
        first, _, second = key.partition(".")
        (config[first] if second else config)[second or first] = value
        (folder / CONFIG).write_text(json.dumps(config))

    return act


def cut(name: str) -> Callable[[Path], object]:
    """Only the first half of a file arrived."""
    return lambda folder: (folder / name).write_bytes(
        (folder / name).read_bytes()[: (folder / name).stat().st_size // 2]
    )


def flip(folder: Path) -> None:
    """One byte of the weights is another one."""
    data = bytearray((folder / WEIGHTS).read_bytes())
    data[-100] ^= 1
    (folder / WEIGHTS).write_bytes(data)


def rewrite(**changes: NDArray[np.float32]) -> Callable[[Path], None]:
    """Put other weights there, with a config that vouches for them."""

    def act(folder: Path) -> None:
        weights = safetensors.numpy.load_file(folder / WEIGHTS)
        data = safetensors.numpy.save({**weights, **{k.replace("_", "."): v for k, v in changes.items()}})
        (folder / WEIGHTS).write_bytes(data)
        change("weights_sha256", hashlib.sha256(data).hexdigest())(folder)

    return act


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (cut(CONFIG), f"{CONFIG}: text, line .*: found .*; expected .*JSON"),
        (cut(WEIGHTS), f"{WEIGHTS}: sha256: found other weights"),
        (flip, f"{WEIGHTS}: sha256: found other weights; expected those that config.json was written with"),
        (lambda folder: (folder / CONFIG).unlink(), f"{CONFIG}: file: found .*No such file"),
        (lambda folder: (folder / WEIGHTS).unlink(), f"{WEIGHTS}: file: found .*No such file"),
        (change("format", "hexwar task policy"), "expected 'hexwar route policy', version 1"),
        (change("version", 2), "expected 'hexwar route policy', version 1"),
        (change("about.ways", 1), f"{CONFIG}: about: found"),
        (change("about.tie", "much"), f"{CONFIG}: about.tie: found 'much'; expected a number of at least 0"),
        (change("about.tie", "-1"), f"{CONFIG}: about.tie: found '-1'; expected a number of at least 0"),
        (
            rewrite(layer1_bias=np.full(64, np.nan, np.float32)),
            "layer1.bias holds numbers that are not finite",
        ),
        (
            rewrite(layer3_weight=np.full((7, 64), np.inf, np.float32)),
            "layer3.weight holds numbers that are not fin",
        ),
        (rewrite(layer3_bias=np.zeros(6, np.float32)), r"layer3.bias has the shape \(6,\), expected \(7,\)"),
        (rewrite(layer4_bias=np.zeros(6, np.float32)), "arrays: found .*'layer4.bias'"),
    ],
)
def test_a_damaged_folder_is_refused_with_file_and_place(
    folder: Path, damage: Callable[[Path], object], message: str
) -> None:
    damage(folder)

    with pytest.raises(PolicyFileError, match=message):
        FrozenLower.load(folder)


def test_a_network_that_reads_other_features_is_refused(folder: Path) -> None:
    """It would read one number for another: the error names both states and what to do."""
    change("about.features", "0123456789abcdef")(folder)

    with pytest.raises(
        PolicyFileError,
        match=rf"features: found '0123456789abcdef', .*; expected '{FEATURES}', .*train the lower level anew",
    ):
        FrozenLower.load(folder)


@pytest.mark.parametrize(
    "size", [{"state": ROUTE_WIDTH + 1}, {"hidden1": 32}, {"hidden2": 65}, {"answers": 6}]
)
def test_other_layers_are_refused(tmp_path: Path, size: dict[str, int]) -> None:
    """As an object and from a folder that is sound in itself."""
    weights = random_weights(**size)
    with pytest.raises(ConfigError, match=r"no network for the drive loop: .* has the shape"):
        FrozenLower(weights)

    FORMAT.save(tmp_path, FORMAT.packed(weights, {"features": FEATURES, "ways": "yes"}, {}))
    name, number = next(iter(size.items()))
    with pytest.raises(PolicyFileError, match=f"features: found .*'{name}': {number}.*; expected"):
        FrozenLower.load(tmp_path)


def test_numbers_that_are_not_finite_are_refused() -> None:
    weights = random_weights() | {"layer2.bias": np.full(64, np.inf, np.float32)}
    with pytest.raises(ConfigError, match=r"layer2\.bias holds numbers that are not finite"):
        FrozenLower(weights)


def test_only_a_network_with_two_hidden_layers_of_64_is_exported() -> None:
    """The paper's (III-C)."""
    for arch, message in (([64], "two hidden layers, got 1"), ([64, 32], "no network for the drive loop")):
        model = MaskedDQN.for_spaces(*route_spaces(), buffer_size=10, policy_kwargs={"net_arch": arch})
        with pytest.raises(ConfigError, match=message):
            freeze_lower(cast("MaskedDQNPolicy", model.policy), ways=True)


def test_a_copy_of_a_dqn_keeps_what_it_was_when_learning_goes_on() -> None:
    model = MaskedDQN.for_spaces(*route_spaces(), buffer_size=10, seed=0)
    frozen = freeze_lower(cast("MaskedDQNPolicy", model.policy), ways=False, scenario="hills")
    before = frozen.q_values(random_states())
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.add_(1.0)

    assert (frozen.q_values(random_states()) == before).all()
    assert not frozen.ways
    assert frozen.about["scenario"] == "hills"


def test_a_folder_of_a_lower_policy_of_a_policy_and_of_a_run_are_found(
    lower: FrozenLower, policy: FrozenPolicy, folder: Path, tmp_path: Path
) -> None:
    with_lower(policy, lower).save(tmp_path / "run" / "policy")

    for place in (
        folder,
        tmp_path / "run" / "policy",
        tmp_path / "run",
        tmp_path / "run" / "policy" / "lower",
    ):
        assert same(lower, make_lower(place))
        assert same(lower, make_lower(str(place)))


def test_names_and_objects_that_answer_are_taken(lower: FrozenLower) -> None:
    assert make_lower("heuristic") == HEURISTIC_LOWER
    assert make_lower(lower) is lower
    assert make_lower(check_answers) is check_answers  # any callable


@pytest.mark.parametrize("nonsense", [None, 7, object(), {"lower": 1}])
def test_what_cannot_answer_is_refused(nonsense: object) -> None:
    with pytest.raises(ConfigError, match='lower is "heuristic", a folder or a callable'):
        make_lower(nonsense)


def test_a_name_that_is_no_folder_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown lower 'heuristik'; did you mean 'heuristic'"):
        make_lower("heuristik")


def test_a_folder_without_a_lower_policy_is_refused(policy: FrozenPolicy, tmp_path: Path) -> None:
    with pytest.raises(PolicyFileError, match=r"config\.json: found nothing; expected a lower policy"):
        make_lower(tmp_path)
    policy.save(tmp_path / "policy")
    with pytest.raises(PolicyFileError, match="expected 'hexwar route policy', version 1"):
        make_lower(tmp_path / "policy")


def test_a_policy_comes_back_with_its_lower_level(
    lower: FrozenLower, policy: FrozenPolicy, tmp_path: Path
) -> None:
    with_lower(policy, lower).save(tmp_path)

    for loaded in (FrozenPolicy.load(tmp_path), make_player(tmp_path)):
        assert isinstance(loaded, FrozenPolicy)
        assert same(lower, loaded.lower)


@pytest.mark.parametrize("without", ["heuristic", check_answers])
def test_a_policy_saved_without_a_network_leaves_none_of_its_predecessors(
    lower: FrozenLower, policy: FrozenPolicy, tmp_path: Path, without: Any
) -> None:
    """Or it would come back with another policy's lower level; a callable cannot be saved."""
    with_lower(policy, lower).save(tmp_path)

    with_lower(policy, without).save(tmp_path)

    assert sorted(path.name for path in tmp_path.iterdir()) == [CONFIG, WEIGHTS]
    assert FrozenPolicy.load(tmp_path).lower == HEURISTIC_LOWER


def test_what_else_is_in_the_folder_of_a_lower_policy_stays(
    lower: FrozenLower, policy: FrozenPolicy, tmp_path: Path
) -> None:
    with_lower(policy, lower).save(tmp_path)
    (tmp_path / "lower" / "notes.txt").write_text("mine")

    policy.save(tmp_path)

    assert [path.name for path in (tmp_path / "lower").iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("damage", [flip, change("about.features", "0123")])
def test_a_policy_with_a_damaged_lower_level_is_refused(
    lower: FrozenLower, policy: FrozenPolicy, tmp_path: Path, damage: Callable[[Path], None]
) -> None:
    with_lower(policy, lower).save(tmp_path)
    damage(tmp_path / "lower")

    with pytest.raises(PolicyFileError, match="lower"):
        FrozenPolicy.load(tmp_path)


def test_answers_that_are_valid_come_back_as_whole_numbers() -> None:
    masks = np.eye(N_ANSWERS, dtype=np.int8)
    found = check_answers(np.arange(7, dtype=np.uint8), masks)
    assert found.dtype == np.int64
    assert found.tolist() == list(range(7))
