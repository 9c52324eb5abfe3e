"""What a study may search, and what a point makes of a preset."""

from __future__ import annotations

import re

import pytest
from optuna.distributions import CategoricalDistribution

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.tuning.space import ALWAYS, SPACE, checked_point, first_point, space_of


def test_alpha_beta_and_delta_t_are_always_searched() -> None:
    assert tuple(space_of()) == ALWAYS == ("alpha", "beta", "decision_ticks")
    assert tuple(space_of(["mixer", "alpha"])) == (*ALWAYS, "mixer")


def test_an_unknown_setting_is_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown setting 'gama'"):
        space_of(["gama"])


def test_every_delta_t_divides_a_game() -> None:
    ticks = load_scenario("plain").game_ticks
    times = SPACE["decision_ticks"]

    assert isinstance(times, CategoricalDistribution)
    assert all(ticks % int(str(choice)) == 0 for choice in times.choices)


@pytest.mark.parametrize("name", PRESETS)
def test_a_study_begins_at_the_papers_point_and_the_presets_own_values(name: str) -> None:
    others = [setting for setting in SPACE if setting != "learning_rate"]  # the paper's is outside
    point = first_point(PRESETS[name], space_of(others))

    assert [point[one] for one in ALWAYS] == [0.01, 0.05, 75]
    assert point["batch_size"] == {"default": 64, "paper": 128}[name]
    assert point["mixer"] == "qmix"
    assert point["td_lambda"] is None
    assert point["spots"] == 6
    assert point["hidden"] == {"default": 128, "paper": 64}[name]


def test_the_default_presets_point_lies_in_the_space() -> None:
    for name, value in first_point(PRESETS["default"], SPACE).items():
        assert SPACE[name]._contains(SPACE[name].to_internal_repr(value)), name


def test_a_point_changes_the_preset_where_it_belongs() -> None:
    point = {"alpha": 0.3, "decision_ticks": 150, "spots": 3, "mixer": "vdn", "hidden": 32, "td_lambda": None}
    changed = PRESETS["default"].changed(point)

    assert (changed.route["alpha"], changed.decision_ticks) == (0.3, 150)
    assert changed.env == {"reward": "net", "priority": 1.0, "spots": 3}
    assert changed.learner["mixer"] == "vdn"
    assert changed.learner["policy_kwargs"] == {"hidden": 32}
    assert changed.learner["learning_rate"] == PRESETS["default"].learner["learning_rate"]
    assert changed.learner["td_lambda"] is None
    assert PRESETS["default"].decision_ticks == 75


POINTS: dict[str, tuple[object, str]] = {
    "no names": ([1, 2], "a point is names and values, got"),
    "another setting": ({"gamma": 0.9}, "unknown setting 'gamma'"),
    "too high": ({"alpha": 2.0}, "alpha must be a number in 0.001..1.0, got 2.0"),
    "a word": ({"beta": "0.1"}, "beta must be a number"),
    "half a tick": ({"decision_ticks": 7.5}, "decision_ticks must be one of 15, 25, 50, 75"),
    "yes": ({"spots": True}, "spots must be a whole number in 2..12"),
    "half a spot": ({"spots": 2.5}, "spots must be a whole number"),
    "no number": ({"alpha": float("nan")}, "alpha must be"),
}


@pytest.mark.parametrize("what", POINTS)
def test_a_point_outside_is_named(what: str) -> None:
    point, message = POINTS[what]
    with pytest.raises((ConfigError, UnknownNameError), match=re.escape(message)):
        checked_point(point, SPACE)


def test_a_point_inside_is_taken() -> None:
    point = {"alpha": 1, "decision_ticks": 15, "spots": 2, "td_lambda": None, "mixer": "vdn"}
    assert checked_point(point, SPACE) == point
