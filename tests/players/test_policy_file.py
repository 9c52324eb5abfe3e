"""A policy as one file: the folder's bytes, checked as the folder is; and both levels as ONNX, value by value."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import onnxruntime  # type: ignore[import-untyped]
import pytest
import safetensors.numpy
from numpy.typing import NDArray

from hexwar_sb3.cli import main
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import FrozenLower, fastest_way_network
from hexwar_sb3.players.onnx_graphs import save_onnx
from hexwar_sb3.players.player import POLICIES, make_player
from hexwar_sb3.players.policy_file import load_policy_file, save_policy_file

HRL0 = POLICIES["HRL0"]


@pytest.fixture(params=["heuristic", "network"])
def policy(request: pytest.FixtureRequest) -> FrozenPolicy:
    lower = fastest_way_network() if request.param == "network" else "heuristic"
    return FrozenPolicy.load(HRL0).led_by(lower)


def run(*arguments: object) -> int:
    with pytest.raises(SystemExit) as stopped:
        main([str(one) for one in arguments])
    return int(str(stopped.value.code))


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_folder_comes_back_byte_for_byte(
    policy: FrozenPolicy, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy.save(tmp_path / "policy")

    assert run("export", tmp_path / "policy", "-o", tmp_path / "mine.safetensors") == 0
    assert run("import", tmp_path / "mine.safetensors") == 0

    assert capsys.readouterr().out.split() == [str(tmp_path / "mine.safetensors"), str(tmp_path / "mine")]
    found = files(tmp_path / "mine")
    assert {name: found[name] for name in files(tmp_path / "policy")} == files(tmp_path / "policy")
    assert sorted(path.name for path in (tmp_path / "mine").iterdir() if path.name[0] != ".") == sorted(
        path.name for path in (tmp_path / "policy").iterdir()
    )
    assert run("import", tmp_path / "mine.safetensors") == 2  # what is there is not written over
    assert "is there already" in capsys.readouterr().err


def test_a_file_plays_like_its_folder(policy: FrozenPolicy, tmp_path: Path) -> None:
    path = tmp_path / "mine.safetensors"
    save_policy_file(policy, path)

    assert make_player(str(path)).sha256 == policy.sha256  # type: ignore[union-attr]
    by_folder, by_file = (play_match(player, "MA1", games=8, seed=1) for player in (policy, path))
    assert by_file.mean_margin == by_folder.mean_margin


def test_a_scripted_player_has_nothing_to_export(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("export", "MA1", "-o", tmp_path / "mine.safetensors") == 2
    assert "MA1 is a scripted player" in capsys.readouterr().err
    assert run("export", "HRL0", "-o", tmp_path / "mine.zip") == 2
    assert "must end in .safetensors or .onnx" in capsys.readouterr().err


Parts = tuple[dict[str, Any], dict[str, str]]  # arrays, configs


def _about(parts: Parts, **words: object) -> None:
    config = json.loads(parts[1]["policy"])
    config.update(words)
    parts[1]["policy"] = json.dumps(config)


BROKEN: dict[str, tuple[Callable[[Parts], object], str]] = {
    "no config": (lambda parts: parts[1].clear(), "metadata: found .*expected a config called 'policy'"),
    "a level without a config": (lambda parts: parts[1].pop("lower"), "levels"),
    "a config without a level": (lambda parts: parts[1].update(more="{}"), "levels"),
    "a stranger among the arrays": (
        lambda parts: parts[0].update({"policy/more": np.zeros(1, np.float32)}),
        "weights.safetensors: sha256",
    ),
    "a weight changed": (
        lambda parts: parts[0]["policy/value.bias"].__setitem__(0, 9.0),
        "weights.safetensors: sha256",
    ),
    "a lower weight changed": (
        lambda parts: parts[0]["lower/layer3.bias"].__setitem__(0, 9.0),
        "lower/weights.safetensors: sha256",
    ),
    "integers": (
        lambda parts: parts[0].update({"policy/value.bias": np.zeros(1, np.int32)}),
        "policy/value.bias: found dtype 'I32'",
    ),
    "no lower level, says the config": (lambda parts: _about(parts, lower=False), "config.json: lower"),
    "other rules": (lambda parts: _about(parts, about={"rules": "xyz"}), "about.rules: found 'xyz'"),
    "another format": (lambda parts: _about(parts, version=2), "config.json: format"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_refused_with_its_place(what: str, tmp_path: Path) -> None:
    change, message = BROKEN[what]
    path = tmp_path / "mine.safetensors"
    save_policy_file(FrozenPolicy.load(HRL0).led_by(fastest_way_network()), path)
    arrays = {name: array.copy() for name, array in safetensors.numpy.load_file(path).items()}
    size = int.from_bytes(path.read_bytes()[:8], "little")
    configs = json.loads(path.read_bytes()[8 : 8 + size])["__metadata__"]
    change((arrays, configs))
    path.write_bytes(safetensors.numpy.save(arrays, metadata=configs))

    with pytest.raises(PolicyFileError, match=message):
        load_policy_file(path, rules="abc" if what == "other rules" else None)


def test_onnx_has_every_value_and_choice_of_both_levels(policy: FrozenPolicy, tmp_path: Path) -> None:
    """In positions of real games."""
    written = save_onnx(policy, tmp_path / "mine.onnx")
    session = onnxruntime.InferenceSession(written[0])
    env = make_vec_env("HexWarTask-v0", n_envs=8, seed=3, opponent="MA1")
    obs = cast("dict[str, NDArray[Any]]", env.reset())
    for _ in range(12):
        given = {key: obs[key] for key in ("obs", "tasks", "action_mask")}
        q, tasks = session.run(None, given)
        np.testing.assert_allclose(q, policy.q_values(obs), rtol=1e-5, atol=1e-4)
        chosen = policy.q_values(obs)
        best, taken = (np.take_along_axis(chosen, one[..., None], -1) for one in (policy.act(obs), tasks))
        assert (best - taken <= 2e-4).all()  # where two are as good
        obs = cast("dict[str, NDArray[Any]]", env.step(policy.act(obs))[0])
    if isinstance(policy.lower, FrozenLower):
        session = onnxruntime.InferenceSession(written[1])
        rng = np.random.default_rng(0)
        states, masks = (
            rng.standard_normal((500, 73), np.float32),
            (rng.random((500, 7)) < 0.6).astype(np.int8),
        )
        masks[:, 0] |= ~masks.any(1)
        q, answers = session.run(None, {"state": states, "mask": masks})
        np.testing.assert_allclose(q, policy.lower.q_values(states), rtol=1e-5, atol=1e-5)
        assert (answers == policy.lower(states, masks)).mean() > 0.995
