"""Presets as files, also a stranger's."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.errors import FileFormatError, HexWarError, UnknownNameError


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_comes_back_as_it_was(name: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    changed = PRESETS[name].changed({"alpha": 0.2, "decision_ticks": 150, "hidden": 32})
    save_preset(path, changed, {"study": "mine"})

    assert load_preset(str(path)) == changed
    assert load_preset(name) is PRESETS[name]


BAD: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "another format": (lambda file: file.update(format="hexwar preset 9"), "format: found hexwar preset 9"),
    "no preset": (lambda file: file.update(preset=[]), "format"),
    "an unknown setting": (
        lambda file: file["preset"].update(rewards=1),
        "rewards: found an unknown setting",
    ),
    "an unknown part": (
        lambda file: file["preset"]["route"].update(opponent="/etc"),
        "route.opponent: found an unknown",
    ),
    "a file of the learner": (
        lambda file: file["preset"]["learner"].update(tensorboard_log="/etc"),
        "learner.tensorboard_log: found an unknown setting",
    ),
    "a class": (
        lambda file: file["preset"]["learner"].update(policy_kwargs={"optimizer_class": "os.system"}),
        "learner.policy_kwargs: found",
    ),
    "a network of terabytes": (
        lambda file: file["preset"]["learner"].update(policy_kwargs={"hidden": 10**9}),
        "learner.policy_kwargs.hidden: found 1000000000; expected a whole number in 1..1024",
    ),
    "a batch of terabytes": (
        lambda file: file["preset"]["learner"].update(batch_size=10**12),
        "learner.batch_size: found 1000000000000",
    ),
    "too many games at once": (
        lambda file: file["preset"].update(n_envs=10**9),
        "preset: found n_envs must be at most 1024, got 1000000000",
    ),
    "half a game": (lambda file: file["preset"].update(n_envs=0.5), "n_envs: found 0.5"),
    "another file as lower level": (lambda file: file["preset"].update(lower="../x"), "lower: found '../x'"),
    "one phase": (
        lambda file: file["preset"].update(phase_ticks=[1]),
        "phase_ticks: found [1]; expected a list",
    ),
    "a list for a number": (
        lambda file: file["preset"]["route"].update(alpha=[1]),
        "route.alpha: found [1]; expected float",
    ),
    "a word for a number": (
        lambda file: file["preset"]["learner"].update(gamma="abc"),
        "learner.gamma: found 'abc'; expected float",
    ),
    "a word for a count": (
        lambda file: file["preset"].update(demo_games="x"),
        "demo_games: found 'x'; expected a whole number",
    ),
    "nothing for a share": (
        lambda file: file["preset"].update(demo_share=None),
        "demo_share: found None; expected a finite number",
    ),
    "a number for a name": (
        lambda file: file["preset"]["learner"].update(mixer=1),
        "learner.mixer: found 1; expected str",
    ),
    "yes for a number": (
        lambda file: file["preset"].update(tie=True),
        "tie: found True; expected a finite number",
    ),
    "a number of 400 digits": (
        lambda file: file["preset"].update(tie=10**400),
        "text: found a number of 401 digits",
    ),
    "half a step": (
        lambda file: file["preset"]["lower_learner"].update(train_freq=0.5),
        "lower_learner.train_freq: found 0.5; expected int",
    ),
    "a learning rate that is none": (
        lambda file: file["preset"]["learner"].update(learning_rate=float("nan")),
        "found NaN, which is no number",
    ),
    "a learning rate of nothing": (
        lambda file: file["preset"]["learner"].update(learning_rate=0.0),
        "preset: found learning_rate must be above 0",
    ),
    "a discount above 1": (
        lambda file: file["preset"]["lower_learner"].update(gamma=1.5),
        "preset: found gamma must be in [0, 1]",
    ),
    "a cost above 1": (
        lambda file: file["preset"]["route"].update(beta=2.0),
        "preset: found beta must be in",
    ),
    "another reward": (lambda file: file["preset"]["env"].update(reward="x"), "preset: found unknown reward"),
    "no decision": (lambda file: file["preset"].update(decision_ticks=0), "preset: found decision_ticks"),
    "a phase of nothing": (
        lambda file: file["preset"].update(phase_ticks=[0, 1]),
        "preset: found phase_ticks",
    ),
    "a share above 1": (lambda file: file["preset"].update(demo_share=2.0), "preset: found demo_share"),
    "yes for a count": (
        lambda file: file["preset"]["learner"].update(batch_size=True),
        "learner.batch_size: found True; expected int",
    ),
    "a list for a part": (
        lambda file: file["preset"].update(env=[]),
        "env: found []; expected names and values",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_a_broken_preset_is_one_error_with_its_place(what: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    save_preset(path, PRESETS["default"], {})
    file = json.loads(path.read_text())
    change, message = BAD[what]
    change(file)
    path.write_text(json.dumps(file))

    with pytest.raises(FileFormatError) as caught:
        load_preset(str(path))
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_pickle_in_disguise_is_no_preset(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_bytes(b"\x80\x04\x95cposix\nsystem\n")
    with pytest.raises(FileFormatError, match="expected a preset's file"):
        load_preset(str(path))


def test_a_name_that_is_neither_preset_nor_file_is_unknown() -> None:
    with pytest.raises(UnknownNameError, match="unknown preset 'defualt'; did you mean 'default'"):
        load_preset("defualt")


def test_nothing_but_our_errors_comes_of_a_bad_file(bad: Any, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    changed = PRESETS["paper"].changed({"alpha": 0.2, "hidden": 32, "spots": 3})
    save_preset(path, changed, {"study": "mine"})
    refused = 0
    for content in bad(json.loads(path.read_text())):
        path.write_bytes(content)
        try:
            load_preset(str(path))
        except (HexWarError, OSError):
            refused += 1
    assert refused > 300


def test_a_key_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    save_preset(path, PRESETS["default"], {})
    path.write_text(path.read_text().replace('"tie":', '"tie": 0.1, "tie":', 1))
    with pytest.raises(FileFormatError, match="the key 'tie' twice"):
        load_preset(str(path))


@pytest.mark.parametrize("make", [os.mkfifo, Path.mkdir, lambda path: path.symlink_to(path)])
def test_what_is_no_regular_file_is_refused(make: Callable[[Path], object], tmp_path: Path) -> None:
    make(tmp_path / "odd.json")
    with pytest.raises(FileFormatError, match=r"odd\.json: file"):
        load_preset(str(tmp_path / "odd.json"))
