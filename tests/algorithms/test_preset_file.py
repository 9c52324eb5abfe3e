"""Presets as files, also a stranger's."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.errors import FileFormatError, UnknownNameError


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
    "too many games at once": (lambda file: file["preset"].update(n_envs=10**9), "n_envs: found 1000000000"),
    "half a game": (lambda file: file["preset"].update(n_envs=0.5), "n_envs: found 0.5"),
    "another file as lower level": (lambda file: file["preset"].update(lower="../x"), "lower: found '../x'"),
    "one phase": (lambda file: file["preset"].update(phase_ticks=[1]), "phase_ticks: found [1]"),
    "a list for a number": (
        lambda file: file["preset"]["route"].update(alpha=[1]),
        "route.alpha: found [1]; expected float",
    ),
    "a word for a number": (
        lambda file: file["preset"]["learner"].update(gamma="abc"),
        "learner.gamma: found 'abc'; expected float",
    ),
    "a word for a count": (lambda file: file["preset"].update(demo_games="x"), "demo_games: found 'x'"),
    "nothing for a share": (lambda file: file["preset"].update(demo_share=None), "demo_share: found None"),
    "a number for a name": (
        lambda file: file["preset"]["learner"].update(mixer=1),
        "learner.mixer: found 1; expected str",
    ),
    "yes for a number": (lambda file: file["preset"].update(tie=True), "tie: found True; expected float"),
    "a number of 400 digits": (lambda file: file["preset"].update(tie=10**400), "tie: found a huge number"),
    "half a step": (
        lambda file: file["preset"]["lower_learner"].update(train_freq=0.5),
        "lower_learner.train_freq: found 0.5; expected int",
    ),
    "a list for a part": (lambda file: file["preset"].update(env=[]), "env: found list"),
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
