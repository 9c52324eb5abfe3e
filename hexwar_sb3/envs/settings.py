"""Settings of the task env, checked once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hexwar_sb3.checks import check_choice, check_flag, check_number, check_share
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.terms import Terms, checked_settings

SIDES = ("red", "blue", "both")
REWARDS = ("paper", "net")
DTYPES = ("float32", "float16")
MOST_PRIORITY = 10


@dataclass(frozen=True, kw_only=True)
class TaskSettings(Terms):
    """What `HexWarTask-v0` can be told, beside the terms of its games; every value is checked here."""

    side: str = "red"  # the learner's camp; "both": red in even episodes, blue in odd ones
    opponent: object = "MA1"  # a player, a list of them, or a list of (player, weight)
    # exponent of the learner's running share of losses: who beats it is met more often; 0: weights alone
    priority: float = 0.0
    lower: object = "heuristic"  # leads the learner's pieces: "heuristic", a policy folder, or a callable
    reward: str = "paper"  # margin by eq. (1); "net": own minus enemy, without green
    privileged_state: bool = False  # adds "state", the truth, for a mixer in training
    warm_start: float = 0.0  # share of episodes that begin near the hot spots (III-C), 0..1
    # who plays the learner's seat in a share of the episodes: a bot, a replay file or a folder of them, a list of these,
    # or a list of (one, weight)
    demo: object = None
    demo_share: float = 0.0  # 0..1
    dtype: str = "float32"  # of the observations; or "float16"

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ConfigError: a setting is out of its range.
            UnknownNameError: a choice that does not exist.
        """
        super().__post_init__()
        check_choice("side", self.side, SIDES)
        check_choice("reward", self.reward, REWARDS)
        check_choice("dtype", self.dtype, DTYPES)
        check_share("warm_start", self.warm_start)
        check_share("demo_share", self.demo_share)
        check_priority(self.priority)
        check_flag("privileged_state", self.privileged_state)
        if self.demo_share > 0 and self.demo is None:
            raise ConfigError("demo_share needs a demo, for example demo='MA1'")
        if self.demo is not None and self.decision_ticks == 1:
            raise ConfigError("a demo needs decision_ticks >= 2: it is watched for one tick first")


def task_settings(settings: dict[str, Any]) -> TaskSettings:
    """Settings from keywords.

    Raises:
        UnknownSettingError: no such setting.
    """
    return checked_settings(TaskSettings, settings)


def check_priority(value: object) -> float:
    """Return an exponent of the share of losses.

    Raises:
        ConfigError: it is out of its range.
    """
    if not 0.0 <= (priority := check_number("priority", value)) <= MOST_PRIORITY:
        raise ConfigError(f"priority must be in 0..{MOST_PRIORITY}, got {value!r}")
    return priority
