"""Settings of `QMIX` for games of others: defaults that know nothing of a war game, and a YAML file that changes them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from hexwar_sb3.algorithms.qmix import POLICY_KWARGS, QMIX
from hexwar_sb3.algorithms.ranges import (
    Misfit,
    Parts,
    Table,
    Whole,
    check_settings,
    flag,
    mended,
    options,
    plain,
)
from hexwar_sb3.checks import check_choice
from hexwar_sb3.envs.joint_action import TEAM_REWARDS
from hexwar_sb3.errors import FileFormatError, HexWarError, UnknownSettingError
from hexwar_sb3.reading import read_bytes

MOST_BYTES = 1 << 16
MOST_ENVS = 4_096
LEARNER: Table = {
    **{name: kind for name, kind in QMIX.settings.items() if name != "seed"},
    **{name: POLICY_KWARGS.table[name] for name in ("mixer", "memory", "share_parameters")},
}
"""Arguments of `QMIX` that a file may hold."""
NEUTRAL: dict[str, Any] = {
    "learning_rate": 5e-4,
    "batch_size": 128,
    "buffer_size": 100_000,
    "learning_starts": 2_000,
    "train_freq": (4, "step"),
    "tau": 0.01,
    "n_steps": 3,
    "reward_scale": None,
    "stickiness": 0.0,
    "exploration_initial_eps": 1.0,
    "exploration_final_eps": 0.05,
}
"""Arguments of `QMIX`; exploration ends after a fifth of the env steps."""
EXPLORING = 5


@dataclass(frozen=True)
class GameSettings:
    """What a YAML file may say of a game and of how it is learned."""

    n_envs: int = 8  # games side by side
    team_reward: str = "mean"  # of the agents' rewards, or their "sum"
    privileged_state: bool = True  # the mixer sees the game's state, where it has one
    last_action: bool = False  # agents see what they did last
    env_kwargs: dict[str, Any] = field(default_factory=dict)  # arguments of the game
    learner: dict[str, Any] = field(default_factory=dict)  # arguments of QMIX

    def __post_init__(self) -> None:
        """Check the settings.

        Raises:
            ConfigError: one is out of its range, or of another kind.
            UnknownSettingError: QMIX has no such argument.
        """
        try:
            mended("n_envs", self.n_envs, Whole(1, MOST_ENVS))
            for name, kind in (
                ("privileged_state", flag),
                ("last_action", flag),
                ("env_kwargs", options),
                ("learner", options),
            ):
                mended(name, getattr(self, name), kind)
        except Misfit as misfit:
            raise misfit.as_setting() from None
        check_choice("team_reward", self.team_reward, TEAM_REWARDS)
        for name in self.learner:
            if name not in LEARNER:
                raise UnknownSettingError("setting", name, LEARNER)
        check_settings(self.learner, LEARNER)

    def arguments(self, n_timesteps: int) -> dict[str, Any]:
        """Arguments of QMIX for a training of so many env steps."""
        return {**NEUTRAL, "exploration_steps": max(1, n_timesteps // EXPLORING), **self.learner}

    @property
    def joint(self) -> dict[str, Any]:
        """Arguments of `make_joint`."""
        return {
            name: getattr(self, name)
            for name in ("env_kwargs", "team_reward", "privileged_state", "last_action")
        }


class _Loader(yaml.SafeLoader):
    """Plain values alone, and each in one place."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.events.AliasEvent):
            raise yaml.YAMLError("an alias; write the value out")
        return super().compose_node(parent, index)


def read_settings(path: Path) -> GameSettings:
    """Read a YAML file of settings.

    Raises:
        FileFormatError: it is missing, too large, no YAML of names and values, or a setting is none.
    """
    text = read_bytes(path, MOST_BYTES, expected="settings (.yaml)")
    try:
        found = plain(yaml.load(text, _Loader))  # noqa: S506  # of plain values
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise FileFormatError(path, "text", found=str(error), expected="YAML of plain values") from error
    if not isinstance(found, dict):
        raise FileFormatError(path, "text", found=type(found).__name__, expected="names and values")
    parts = Parts({}, others=tuple(GameSettings.__dataclass_fields__))
    try:
        return GameSettings(**parts(found))
    except (HexWarError, Misfit, TypeError) as error:
        raise FileFormatError(path, "settings", found=str(error), expected="known ones") from error
