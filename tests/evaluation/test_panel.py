from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.players.terms import Terms, trained_terms

TERMS = Terms(scenario="hills@7", decision_ticks=150, spots=3, decisions="event")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A policy that was trained in games of its own kind."""
    QMIX("TaskPolicy", make_vec_env(seed=0), buffer_size=10).policy.freeze(**TERMS.about()).save(tmp_path)
    return tmp_path


def test_a_policys_folder_says_how_it_was_trained(folder: Path) -> None:
    assert trained_terms(folder) == TERMS


def test_a_folder_of_version_0_1_says_it_in_its_own_words(folder: Path) -> None:
    say(folder, early="yes", decisions=None)

    assert trained_terms(folder) == TERMS


def test_what_a_folder_does_not_say_is_as_usual(folder: Path) -> None:
    say(folder, decision_ticks=None, decisions=None)

    assert trained_terms(folder) == replace(TERMS, decision_ticks=75, decisions="fixed")
    assert trained_terms(folder, Terms(decision_ticks=50)).decision_ticks == 50


def test_a_bot_was_not_trained() -> None:
    assert trained_terms("MA1") == Terms()


def test_a_word_that_is_none_is_answered_with_its_place(folder: Path) -> None:
    say(folder, decisions="sometimes")

    with pytest.raises(PolicyFileError, match=r"about: found unknown decisions 'sometimes'"):
        trained_terms(folder)


def say(folder: Path, **words: str | None) -> None:
    """Change what a folder says of its training; None takes a word away."""
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    about = {**config["about"], **words}
    config["about"] = {name: word for name, word in about.items() if word is not None}
    (folder / "config.json").write_text(json.dumps(config), encoding="utf-8")


@pytest.mark.parametrize("number", ["seventy", "-1", "1e9", "9" * 5000, ""])
def test_a_number_that_is_none_is_answered_with_its_place(folder: Path, number: str) -> None:
    say(folder, decision_ticks=number)

    with pytest.raises(PolicyFileError, match=r"about\.decision_ticks: found .*; expected a whole number"):
        trained_terms(folder)


def test_games_and_env_steps_are_counted_by_the_clock() -> None:
    """A game of 1,800 ticks, also where Delta-t does not divide it."""
    assert Terms().env_steps(100) == 2_400
    assert Terms().games(240_000) == 10_000
    assert Terms(decision_ticks=70).games(240_000) == 240_000 * 70 // 1_800
