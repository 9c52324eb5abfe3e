"""Settings of the task env, checked once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.errors import ConfigError, UnknownNameError, UnknownSettingError, shortened
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.records import DECISION_TICKS
from hexwar_sb3.tasks.spots import SPOTS

Settings = TypeVar("Settings")
SIDES = ("red", "blue", "both")
REWARDS = ("paper", "net")
DECISIONS = ("fixed", "event")
DTYPES = ("float32", "float16")
MOST_PRIORITY = 10


@dataclass(frozen=True, kw_only=True)
class TaskSettings:
    """What `HexWarTask-v0` can be told; every value is checked here."""

    scenario: str | Path | Scenario = "plain"  # name, file or object
    side: str = "red"  # the learner's camp; "both": red in even episodes, blue in odd ones
    opponent: object = "MA1"  # a player, a list of them, or a list of (player, weight)
    # exponent of the learner's running share of losses: who beats it is met more often; 0: weights alone
    priority: float = 0.0
    decision_ticks: int = DECISION_TICKS  # Delta-t, ticks
    decisions: str = "fixed"  # "event": also after an own loss or an ended task
    lower: object = "heuristic"  # leads the learner's pieces: "heuristic", a policy folder, or a callable
    reward: str = "paper"  # margin by eq. (1); "net": own minus enemy, without green
    spots: int = SPOTS  # k of G^L(k): cells that tasks lead to beside the control points
    fog: bool = True  # False: lights on, for debugging
    privileged_state: bool = False  # adds "state", the truth, for a mixer in training
    warm_start: float = 0.0  # share of episodes that begin near the hot spots (III-C), 0..1
    demo_bot: str | None = None  # plays the learner's seat in a share of the episodes
    demo_share: float = 0.0  # 0..1
    dtype: str = "float32"  # of the observations; or "float16"

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ConfigError: a setting is out of its range.
            UnknownNameError: a choice that does not exist.
        """
        check_scenario(self.scenario)
        check_choice("side", self.side, SIDES)
        check_choice("reward", self.reward, REWARDS)
        check_choice("decisions", self.decisions, DECISIONS)
        check_choice("dtype", self.dtype, DTYPES)
        check_share("warm_start", self.warm_start)
        check_share("demo_share", self.demo_share)
        check_priority(self.priority)
        check_whole("decision_ticks", self.decision_ticks, least=1)
        check_whole("spots", self.spots, least=0)
        check_flag("fog", self.fog)
        check_flag("privileged_state", self.privileged_state)
        if self.demo_share > 0 and self.demo_bot is None:
            raise ConfigError("demo_share needs a demo_bot, for example demo_bot='MA1'")
        if self.demo_bot is not None and self.decision_ticks == 1:
            raise ConfigError("a demo_bot needs decision_ticks >= 2: it is watched for one tick first")


def task_settings(settings: dict[str, Any]) -> TaskSettings:
    """Settings from keywords.

    Raises:
        UnknownSettingError: no such setting.
    """
    return checked_settings(TaskSettings, settings)


def checked_settings(kind: type[Settings], settings: dict[str, Any]) -> Settings:
    """Settings of a kind from keywords.

    Raises:
        UnknownSettingError: it has no such setting.
    """
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]  # every kind is a dataclass
    for name in settings:
        if name not in known:
            raise UnknownSettingError("setting", name, known)
    return kind(**settings)


def check_scenario(scenario: object) -> None:
    """Check the kind of a scenario; whether it exists is seen when it is loaded.

    Raises:
        ConfigError: it is neither a name, a file nor an object.
    """
    if not isinstance(scenario, str | Path | Scenario):
        raise ConfigError(f"scenario is a name, a file or a Scenario, got {shortened(repr(scenario))}")


def check_choice(setting: str, value: object, choices: Iterable[str]) -> None:
    """Check a choice by name.

    Raises:
        UnknownNameError: it does not exist.
    """
    if not isinstance(value, str) or value not in choices:
        raise UnknownNameError(setting, str(value), choices)


def check_flag(setting: str, value: object) -> None:
    """Check a setting that is on or off.

    Raises:
        ConfigError: it is neither True nor False; a text such as "false" would count as True.
    """
    if not isinstance(value, bool | np.bool_):
        raise ConfigError(f"{setting} must be True or False, got {shortened(repr(value))}")


def check_number(setting: str, value: object) -> float:
    """Return a number.

    Raises:
        ConfigError: it is none.
    """
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise ConfigError(f"{setting} must be a number, got {shortened(repr(value))}")
    return float(value)


def check_priority(value: object) -> float:
    """Return an exponent of the share of losses.

    Raises:
        ConfigError: it is out of its range.
    """
    if not 0.0 <= (priority := check_number("priority", value)) <= MOST_PRIORITY:
        raise ConfigError(f"priority must be in 0..{MOST_PRIORITY}, got {value!r}")
    return priority


def check_share(setting: str, value: object) -> float:
    """Return a share of episodes.

    Raises:
        ConfigError: it is not in 0..1.
    """
    share = check_number(setting, value)
    if not 0.0 <= share <= 1.0:
        raise ConfigError(f"{setting} must be in 0..1, got {value!r}")
    return share
