"""Presets as files: what a study found, for `hexwar train --preset FILE`."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hexwar_sb3.algorithms.presets import LEARNER, PARTS, PRESETS, WIDTHS, Preset
from hexwar_sb3.errors import FileFormatError, UnknownNameError
from hexwar_sb3.files import write_json
from hexwar_sb3.reading import read_json

FORMAT = "hexwar preset 1"
LOWERS = ("learned", "heuristic")  # a file names no other file
ROUTE = ("alpha", "beta", "beta_per", "ways", "gain_limit", "keep_task", "wander", "shaping")
LOWER_LEARNER = (
    *(
        "learning_rate",
        "final_learning_rate",
        "learning_rate_steps",
        "buffer_size",
        "batch_size",
        "train_freq",
    ),
    *("gradient_steps", "tau", "target_update_interval", "gamma", "n_steps"),
    *("exploration_initial_eps", "exploration_final_eps", "exploration_steps"),
)
KNOWN = {
    "env": [name for name, (part, _) in PARTS.items() if part == "env"],
    "route": ROUTE,
    "learner": (*LEARNER, "loss", "exploration_every", "policy_kwargs"),
    "lower_learner": LOWER_LEARNER,
}
"""Settings that a file may hold in each part."""
MOST = {
    "n_envs": 1_024,
    "batch_size": 65_536,
    "buffer_size": 1_000_000,
    "n_steps": 1_000,
    "gradient_steps": 1_000,
}
MOST |= dict.fromkeys(WIDTHS, 1_024)
"""Limits of those that cost memory or time."""
MOST_WHOLE = 10**12
PLAIN = {"float": (float, int), "int": (int,), "bool": (bool,), "str": (str,), "None": (type(None),)}
"""Types that an annotation's word stands for."""


def load_preset(name: str) -> Preset:
    """Take a preset by its name, or from a file.

    Raises:
        UnknownNameError: there is neither.
        FileFormatError: the file is broken.
    """
    if name in PRESETS:
        return PRESETS[name]
    path = Path(name)
    if not path.is_file():
        raise UnknownNameError("preset", name, PRESETS)
    found = read_json(path, "a preset's file")
    if found.get("format") != FORMAT or not isinstance(found.get("preset"), dict):
        raise FileFormatError(path, "format", found=str(found.get("format"))[:40], expected=f"{FORMAT!r}")
    return Preset(**_checked(path, found["preset"]))


def save_preset(path: Path, preset: Preset, about: Mapping[str, Any]) -> None:
    """Write a preset, and what it comes from."""
    write_json(path, {"format": FORMAT, "about": dict(about), "preset": asdict(preset)})


def _checked(path: Path, values: dict[str, Any]) -> dict[str, Any]:
    """Values of a stranger's preset: known names, plain values of their kinds, no more than a machine can bear."""
    own = _kinds(Preset)
    for name, value in values.items():
        if name not in own:
            raise FileFormatError(path, name[:40], found="an unknown setting", expected=", ".join(own))
        if name in KNOWN:
            _check_part(path, name, value)
        elif name == "phase_ticks":
            if not (isinstance(value, list) and len(value) == 2 and all(type(one) is int for one in value)):
                raise FileFormatError(path, name, found=repr(value)[:40], expected="two whole numbers")
        elif name == "lower":
            if value not in LOWERS:
                raise FileFormatError(path, name, found=repr(value)[:40], expected=" or ".join(LOWERS))
        else:
            _check_value(path, name, value, own[name])
    phases = {"phase_ticks": tuple(values["phase_ticks"])} if "phase_ticks" in values else {}
    return {**values, **phases}


def _check_part(path: Path, part: str, values: object) -> None:
    if not isinstance(values, dict):
        raise FileFormatError(path, part, found=type(values).__name__, expected="names and values")
    kinds = _kinds(_owner(part))
    for name, value in values.items():
        place = f"{part}.{name}"[:60]
        if name not in KNOWN[part]:
            raise FileFormatError(path, place, found="an unknown setting", expected=", ".join(KNOWN[part]))
        if name == "policy_kwargs":
            if not isinstance(value, dict) or not set(value) <= set(WIDTHS):
                raise FileFormatError(path, place, found=repr(value)[:40], expected=f"some of {WIDTHS}")
            for width, number in value.items():
                _check_value(path, f"{place}.{width}", number, "int")
        else:
            _check_value(path, place, value, kinds[name])


def _owner(part: str) -> type:
    """Whose arguments the settings of a part are."""
    from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
    from hexwar_sb3.algorithms.qmix import QMIX
    from hexwar_sb3.envs.route_settings import RouteSettings
    from hexwar_sb3.envs.settings import TaskSettings

    owners = {"env": TaskSettings, "route": RouteSettings, "learner": QMIX, "lower_learner": MaskedDQN}
    return owners[part]


def _kinds(owner: type) -> dict[str, str]:
    """Annotations of an owner's arguments, as they are written."""
    return {name: str(one.annotation) for name, one in inspect.signature(owner).parameters.items()}


def _check_value(path: Path, place: str, value: object, kind: str) -> None:
    kinds = [name for name in kind.split(" | ") if name in PLAIN]
    if not any(type(value) in PLAIN[name] for name in kinds):
        raise FileFormatError(path, place, found=repr(value)[:40], expected=" or ".join(kinds))
    if type(value) is int and abs(value) > MOST_WHOLE:
        raise FileFormatError(path, place, found="a huge number", expected=f"at most {MOST_WHOLE}")
    most = MOST.get(place.rpartition(".")[2])
    if most is not None and not (type(value) is int and 1 <= value <= most):
        raise FileFormatError(path, place, found=repr(value)[:40], expected=f"a whole number in 1..{most}")
