"""The scripted players are the accepted ones, and the bars see who is not (bots.md, section 4)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.bots.config import bots_hash
from hexwar_sb3.bots.registry import BOTS_VERSION
from hexwar_sb3.evaluation.acceptance import FIRST_GAMES, Accept, failures_of, pairings, unused
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.terms import Terms

ACCEPTED = Path(__file__).parents[2] / "results" / "bots" / "acceptance.json"


@pytest.fixture(scope="module")
def accepted() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(ACCEPTED.read_text(encoding="utf-8"))
    return found


def row(red: str, blue: str, win_rate: float, taken: float = 1.0) -> dict[str, Any]:
    return {"red": red, "blue": blue, "win_rate": win_rate, "taken": [taken, taken]}


def test_every_map_was_accepted_with_2000_games_a_figure(accepted: dict[str, Any]) -> None:
    assert sorted(accepted["maps"]) == sorted(STANDARD)
    assert accepted["games"] >= 2000
    assert accepted["failures"] == []
    for found in accepted["maps"].values():
        assert failures_of(found["rows"]) == unused(found["used"]) == []
        assert [(each["red"], each["blue"]) for each in found["rows"]] == list(pairings())


def test_the_players_are_those_that_were_accepted(accepted: dict[str, Any]) -> None:
    for found in accepted["maps"].values():
        assert found["bots"] == f"{BOTS_VERSION} {bots_hash()}"


@pytest.mark.parametrize("scenario", STANDARD)
@pytest.mark.parametrize(("red", "blue"), [("MA1", "MA2"), ("MA2", "MA1"), ("MA1", "MA1"), ("MA2", "MA2")])
def test_they_still_play_the_accepted_games(
    accepted: dict[str, Any], scenario: str, red: str, blue: str
) -> None:
    rows = accepted["maps"][scenario]["rows"]
    known = next(each for each in rows if (each["red"], each["blue"]) == (red, blue))
    seed = seed_for(Purpose.REPORT, accepted["seed"])
    again = play_games(red, blue, FIRST_GAMES, Terms(scenario=scenario), seed)
    assert again.margin.tolist() == known["first_margins"]


@pytest.mark.parametrize(
    ("made_up", "failure"),
    [
        (row("MA1", "random", 0.94), "MA1 as red wins 0.940 against random"),
        (row("nearest", "MA2", 0.21), "MA2 as blue wins 0.790 against nearest"),
        (row("all-main", "MA1", 0.36), "MA1 as blue wins 0.640 against all-main"),
        (row("MA2", "MA2", 0.53), "MA2 against itself wins 0.530 as red"),
        (row("MA1", "MA2", 0.66), "MA1 wins 0.660 against MA2"),
        (row("MA1", "MA2", 0.5, taken=0.7), "point 0 is taken in 0.700 of the games"),
    ],
)
def test_a_missed_bar_is_named(made_up: dict[str, Any], failure: str) -> None:
    assert failure in failures_of([made_up])
    assert failures_of([row("MA1", "MA2", 0.64), row("MA1", "nearest", 0.8), row("MA1", "MA1", 0.515)]) == []


def test_an_unused_action_is_named() -> None:
    assert unused({"MA1": {"HIDE": 0.5, "GET_ON": 0.005}}) == ["MA1 uses GET_ON in 0.0050 of its games"]


def test_a_run_gives_a_row_for_each_pairing() -> None:
    found = Accept(games=1, scenarios=("plain",)).accept("plain")
    assert len(found["rows"]) == len(list(pairings()))
    assert set(found["used"]["MA1"]) == set(found["used"]["MA2"])
