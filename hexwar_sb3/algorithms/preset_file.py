"""Presets as files: what a study found, for `hexwar train --preset FILE`."""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hexwar_sb3.algorithms.presets import LEARNER, OF_POLICY, PARTS, PRESETS, Preset
from hexwar_sb3.algorithms.ranges import check_settings
from hexwar_sb3.checks import check_whole
from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError, UnknownNameError
from hexwar_sb3.files import write_json
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.scenario import MAX_GAME_TICKS
from hexwar_sb3.reading import read_json

FORMAT = "hexwar preset 1"
LIMIT = "gain_limit"  # of the route: may be infinite
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
MOST |= {name: 1_024 for name, kind in OF_POLICY.items() if kind == "int"}
"""Limits of those that cost memory or time."""
MOST_WHOLE = 10**12
PLAIN = {"float": (float, int), "int": (int,), "bool": (bool,), "str": (str,), "None": (type(None),)}
"""Types that an annotation's word stands for."""


def load_preset(name: str) -> Preset:
    """Take a preset by its name, or from a file.

    Raises:
        UnknownNameError: there is neither.
        FileFormatError: the file is broken.

    Example:
        >>> preset = load_preset("paper").changed({"decision_ticks": 150})
        >>> preset.decision_ticks, preset.learner["n_steps"]
        (150, 1)
    """
    if name in PRESETS:
        return PRESETS[name]
    path = Path(name)
    if not os.path.lexists(path):
        raise UnknownNameError("preset", name, PRESETS)
    found = read_json(path, "a preset's file")
    if found.get("format") != FORMAT or not isinstance(found.get("preset"), dict):
        raise FileFormatError(path, "format", found=str(found.get("format"))[:40], expected=f"{FORMAT!r}")
    values = read_fields(Preset, found["preset"], path)
    if values.get("lower", LOWERS[0]) not in LOWERS:
        raise FileFormatError(path, "lower", found=repr(values["lower"]), expected=" or ".join(LOWERS))
    for part in KNOWN:
        values[part] = _checked_part(path, part, values.get(part, {}))
    preset = Preset(**values)
    try:
        check_preset(preset)
    except HexWarError as error:
        raise FileFormatError(
            path, "preset", found=str(error), expected="settings in their ranges"
        ) from error
    return preset


def save_preset(path: Path, preset: Preset, about: Mapping[str, Any]) -> None:
    """Write a preset, and what it comes from; JSON has no infinity, so that no limit is null."""
    values = asdict(preset)
    if values["route"].get(LIMIT) == math.inf:
        values["route"][LIMIT] = None
    write_json(path, {"format": FORMAT, "about": dict(about), "preset": values})


def check_preset(preset: Preset) -> None:
    """Check the ranges of all that a preset says.

    Raises:
        ConfigError: a number is out of its range.
        UnknownNameError: a choice that does not exist.
    """
    from hexwar_sb3.checks import check_share
    from hexwar_sb3.envs.route_settings import RouteSettings
    from hexwar_sb3.envs.settings import TaskSettings

    check_whole("decision_ticks", preset.decision_ticks, least=1, most=MAX_GAME_TICKS)
    check_whole("n_envs", preset.n_envs, least=1, most=MOST["n_envs"])
    check_whole("demo_games", preset.demo_games, least=0, most=MOST_WHOLE)
    for ticks, least in zip(preset.phase_ticks, (1, 0), strict=True):
        check_whole("phase_ticks", ticks, least=least, most=MOST_WHOLE)
    for name in ("demo_share", "warm_start"):
        check_share(name, getattr(preset, name))
    if not 0.0 <= preset.tie < math.inf:
        raise ConfigError(f"tie must be finite and at least 0, got {preset.tie}")
    TaskSettings(**preset.env)
    RouteSettings(**preset.route)
    for part in ("learner", "lower_learner"):
        settings = getattr(preset, part)
        check_settings(settings, _owner(part).settings)
        if settings.get("learning_rate") == 0.0:  # for play alone
            raise ConfigError("learning_rate must be above 0, got 0")


def _checked_part(path: Path, part: str, values: dict[str, Any]) -> dict[str, Any]:
    """Values of a part: known names, plain values of their kinds, no more than a machine can bear."""
    if part == "route" and values.get(LIMIT, 0.0) is None:
        values = {**values, LIMIT: math.inf}
    _check_part(path, part, values)
    return values


def _check_part(path: Path, part: str, values: dict[str, Any]) -> None:
    kinds = kinds_of(_owner(part))
    for name, value in values.items():
        place = f"{part}.{name}"[:60]
        if name not in KNOWN[part]:
            raise FileFormatError(path, place, found="an unknown setting", expected=", ".join(KNOWN[part]))
        if name == "policy_kwargs":
            if not isinstance(value, dict) or not set(value) <= set(OF_POLICY):
                expected = f"some of {tuple(OF_POLICY)}"
                raise FileFormatError(path, place, found=repr(value)[:40], expected=expected)
            for one, its in value.items():
                _check_value(path, f"{place}.{one}", its, OF_POLICY[one])
        else:
            _check_value(path, place, value, kinds[name])


def _owner(part: str) -> Any:
    """Whose arguments the settings of a part are."""
    from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
    from hexwar_sb3.algorithms.qmix import QMIX
    from hexwar_sb3.envs.route_settings import RouteSettings
    from hexwar_sb3.envs.settings import TaskSettings

    owners = {"env": TaskSettings, "route": RouteSettings, "learner": QMIX, "lower_learner": MaskedDQN}
    return owners[part]


def kinds_of(owner: type) -> dict[str, str]:
    """Annotations of an owner's arguments, as they are written."""
    return {name: str(one.annotation) for name, one in inspect.signature(owner).parameters.items()}


def _check_value(path: Path, place: str, value: object, kind: str) -> None:
    if not is_plain(value, kind):
        expected = " or ".join(name for name in kind.split(" | ") if name in PLAIN)
        raise FileFormatError(path, place, found=repr(value)[:40], expected=expected)
    if type(value) is int and abs(value) > MOST_WHOLE:
        raise FileFormatError(path, place, found="a huge number", expected=f"at most {MOST_WHOLE}")
    most = MOST.get(place.rpartition(".")[2])
    if most is not None and not (type(value) is int and 1 <= value <= most):
        raise FileFormatError(path, place, found=repr(value)[:40], expected=f"a whole number in 1..{most}")


def is_plain(value: object, kind: str) -> bool:
    """Whether a value is of one of the plain kinds that an annotation names."""
    return any(type(value) in PLAIN[name] for name in kind.split(" | ") if name in PLAIN)
