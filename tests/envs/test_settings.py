"""Bad settings are refused with a sentence."""

from __future__ import annotations

from typing import Any

import pytest

from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.settings import task_settings
from hexwar_sb3.errors import ConfigError, HexWarError, UnknownNameError


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"side": "green"}, "side"),
        ({"reward": "score"}, "reward"),
        ({"decisions": "never"}, "decisions"),
        ({"dtype": "int8"}, "dtype"),
        ({"decision_ticks": 0}, "decision_ticks"),
        ({"decision_ticks": 7.5}, "decision_ticks"),
        ({"warm_start": 1.5}, "warm_start"),
        ({"demo_share": 0.5}, "demo_bot"),
        ({"opponnent": "MA1"}, "did you mean 'opponent'"),
    ],
)
def test_a_bad_setting_is_named(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(HexWarError, match=message):
        task_settings(setting)


def test_an_unknown_env_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="HexWarTask-v0"):
        make_vec_env("HexWarTask-v1", seed=0)


def test_an_unknown_opponent_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'MA"):
        make_vec_env("HexWarTask-v0", opponent="MA", seed=0)


def test_no_games_are_refused() -> None:
    with pytest.raises(ConfigError, match="n_envs"):
        make_vec_env("HexWarTask-v0", n_envs=0, seed=0)
