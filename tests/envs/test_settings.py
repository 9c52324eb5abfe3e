"""Bad settings are refused with a sentence."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.envs.flat_games import flat_settings
from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import ENVS, make_vec_env
from hexwar_sb3.envs.route_settings import RouteSettings, route_settings
from hexwar_sb3.envs.settings import TaskSettings, task_settings
from hexwar_sb3.errors import ConfigError, HexWarError, UnknownNameError, UnknownSettingError


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
        ({"demo_share": 0.5}, "demo_share needs a demo, for example demo='MA1'"),
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


WRONG: list[Any] = [
    None,
    3.5,
    "x",
    b"plain",
    [],
    {},
    [[1]],
    np.array([1, 2]),
    object(),
    int,
    float("nan"),
    -1,
]
TAKEN: dict[str, list[Any]] = {  # what is no mistake
    "demo": [None],
    "gain_limit": [3.5],
    "alpha": [3.5],
    "priority": [3.5],
}


def setting_names(kind: type) -> list[str]:
    return [field.name for field in fields(kind)]


@pytest.mark.parametrize("name", setting_names(TaskSettings))
def test_a_task_setting_of_a_wrong_kind_is_refused_in_words(name: str) -> None:
    for value in WRONG:
        if not any(value is taken for taken in TAKEN.get(name, [])):
            with pytest.raises(HexWarError):
                gymnasium.make("HexWarTask-v0", disable_env_checker=True, **{name: value})


@pytest.mark.parametrize("name", setting_names(RouteSettings))
def test_a_route_setting_of_a_wrong_kind_is_refused_in_words(name: str) -> None:
    for value in WRONG:
        if value not in TAKEN.get(name, []) if isinstance(value, float) else True:
            with pytest.raises(HexWarError):
                make_vec_env("HexWarRoute-v0", seed=0, **{name: value})


@pytest.mark.parametrize(
    "setting",
    [
        {"decision_ticks": np.int64(75), "spots": np.int32(3)},
        {"warm_start": np.float32(0.5), "fog": np.bool_(True), "privileged_state": np.bool_(False)},
        {"scenario": Game("plain").world.scenario, "side": np.str_("blue")},
        {"demo": "MA1", "demo_share": 1},
    ],
)
def test_settings_come_in_numpys_types_too(setting: dict[str, Any]) -> None:
    assert make_vec_env("HexWarTask-v0", seed=0, **setting).reset() is not None


@pytest.mark.parametrize("settings", [task_settings, route_settings, flat_settings])
def test_an_unknown_keyword_is_a_type_error_with_pythons_own_phrase(settings: Any) -> None:
    """Wrappers of others look for it, as TorchRL's does for `frameskip`."""
    with pytest.raises(TypeError, match="got an unexpected keyword argument 'frameskip'"):
        settings({"frameskip": 4})
    with pytest.raises(UnknownNameError, match="did you mean 'side'"):
        settings({"sides": "red"})


@pytest.mark.parametrize("env_id", ENVS)
def test_every_way_to_make_an_env_refuses_an_unknown_keyword_so(env_id: str) -> None:
    for make in (gymnasium.make, make_vec_env):
        with pytest.raises(UnknownSettingError, match="got an unexpected keyword argument 'frameskip'"):
            make(env_id, frameskip=4)
    with pytest.raises(TypeError, match="got an unexpected keyword argument 'frameskip'"):
        parallel_env(frameskip=4)


@pytest.mark.parametrize("wrong", [None, 3, ["HexWarTask-v0"], ""])
def test_what_is_no_env_id_is_refused(wrong: Any) -> None:
    with pytest.raises(UnknownNameError, match="unknown env"):
        make_vec_env(wrong)


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("wrong", ["ansi", 3, ["rgb_array"]])
def test_a_render_mode_that_is_none_is_refused(env_id: str, wrong: Any) -> None:
    kind = gymnasium.spec(env_id).entry_point
    with pytest.raises(UnknownNameError, match="unknown render_mode"):
        gymnasium.envs.registration.load_env_creator(str(kind))(render_mode=wrong)


def test_a_demo_player_that_is_no_bot_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"demo is a bot, which runs .* or a folder of them; got 'HRL0'"):
        make_vec_env(demo="HRL0", demo_share=0.5)


@pytest.mark.parametrize("env_id", ENVS)
def test_a_camp_without_pieces_is_refused(env_id: str) -> None:
    scenario = Game.from_text("map plain-9x5\nred tank 0103\nblue tank 0403").world.scenario
    alone = type(scenario)(
        name="alone",
        hexmap=scenario.hexmap,
        pieces=scenario.pieces[:1],
        points=scenario.points,
        game_ticks=10,
    )
    with pytest.raises(ConfigError, match="'alone': blue has no pieces"):
        make_vec_env(env_id, scenario=alone)
    with pytest.raises(ConfigError, match="'alone': blue has no pieces"):
        parallel_env(alone)


def test_several_scenarios_are_a_list() -> None:
    assert route_settings({"scenario": ["plain", Path("b.scenario.json")]}).fields[0] == "plain"
    with pytest.raises(ConfigError, match="scenario is a name, a file or a Scenario, got <generator"):
        route_settings({"scenario": (name for name in ["plain"])})


def test_settings_may_come_in_one_dict_as_sb3_takes_them() -> None:
    env = make_vec_env("HexWarTask-v0", seed=0, env_kwargs={"decision_ticks": 150, "dtype": "float16"})
    assert env.get_attr("games")[0].settings.decision_ticks == 150
    with pytest.raises(UnknownSettingError, match="did you mean 'opponent'"):
        make_vec_env(env_kwargs={"opponnt": "MA2"})
    with pytest.raises(ConfigError, match="opponent: said by env_kwargs and by keyword"):
        make_vec_env(env_kwargs={"opponent": "MA2"}, opponent="MA1")
