"""What a league can be told."""

from __future__ import annotations

from typing import Any

import pytest

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.league.settings import LeagueSettings

WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "nobody kept": ({"keep": 0}, "keep must be an integer >= 1, got 0"),
    "no games": ({"games": -1}, "games must be an integer >= 1"),
    "half a game": ({"match_games": 0.5}, "match_games must be an integer >= 1"),
    "a share above one": ({"partner_share": 1.5}, r"partner_share must be in 0\.\.1"),
    "not a number": ({"past_share": float("nan")}, r"past_share must be in 0\.\.1"),
    "shares above one": ({"partner_share": 0.7, "past_share": 0.6}, "must add up to at most 1"),
    "too many games at once": ({"n_envs": 10**9}, "n_envs must be at most 1024"),
    "a replay of terabytes": (
        {"learner": {"buffer_size": 10**12}},
        "buffer_size of the learner must be at most 1000000",
    ),
    "an update of terabytes": (
        {"learner": {"batch_size": 10**12}},
        "batch_size of the learner must be at most 65536",
    ),
    "a file of the learner": (
        {"learner": {"tensorboard_log": "/etc"}},
        "unknown argument of the learner 'tensorboard_log'",
    ),
    "an object of the learner": ({"learner": {"gamma": [0.9]}}, "gamma of the learner is a number or a name"),
    "a text for a share": ({"past_share": "all"}, "past_share must be a number, got 'all'"),
    "a bot that is none": ({"opponents": (7,)}, "scenario and opponents are names"),
    "a bot twice": ({"opponents": ("MA1", "MA1")}, "each opponent is named once"),
    "a rest for nobody": ({"opponents": ()}, "without opponents"),
    "a share of two": ({"worst_share": 2.0}, r"worst_share must be in 0\.\.1"),
    "half a split": ({"split": 1}, "split must be True or False, got 1"),
    "a priority of none": ({"priority": "MA1"}, "priority must be a number"),
    "a priority without end": ({"priority": 1e9}, r"priority must be in 0\.\.10"),
    "a weight of none": ({"opponents": ("MA1=",)}, "unknown opponent 'MA1='"),
    "a text for a learning rate": (
        {"learner": {"learning_rate": "fast"}},
        "learning_rate of the learner must be a number",
    ),
}


def test_a_league_takes_what_hexwar_train_makes() -> None:
    env = make_vec_env("HexWarTask-v0", n_envs=1, privileged_state=True)
    made = QMIX("TaskPolicy", env, **PRESETS["default"].learner_for(1, "plain")).policy.freeze().sizes
    widest = LeagueSettings()

    assert (made["hidden"], made["embed"]) == (widest.hidden, widest.embed)


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_setting_is_named(what: str) -> None:
    settings, message = WRONG[what]
    with pytest.raises(HexWarError, match=message):
        LeagueSettings(**settings)
