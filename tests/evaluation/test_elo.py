"""Elo ratings: known strengths are found again, and what cannot be known has a wide interval."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.elo import MEAN, Against, Pairing, elo_ratings, rate_player

STRENGTHS = {"weak": 1400.0, "middle": 1500.0, "strong": 1600.0}
SEAT = {"fair": 0.0, "tilted": 60.0}  # what red's seat is worth


def expected(difference: float) -> float:
    return float(1.0 / (1.0 + 10.0 ** (-difference / 400.0)))


def pairings(games: int) -> list[Pairing]:
    """Games that end exactly as the strengths say."""
    return [
        Pairing(
            red=red,
            blue=blue,
            games=games,
            score=games * expected(STRENGTHS[red] - STRENGTHS[blue] + seat),
            scenario=scenario,
        )
        for scenario, seat in SEAT.items()
        for red in STRENGTHS
        for blue in STRENGTHS
    ]


def test_ratings_are_those_that_the_games_were_made_with() -> None:
    found = elo_ratings(pairings(1_000_000))

    for name, strength in STRENGTHS.items():
        assert found.players[name].value == pytest.approx(strength, abs=0.1)
    for scenario, seat in SEAT.items():
        assert found.red_seat[scenario].value == pytest.approx(seat, abs=0.1)


def test_ratings_have_their_mean_at_1500() -> None:
    found = elo_ratings(pairings(50)[3:])

    assert np.mean([elo.value for elo in found.players.values()]) == pytest.approx(MEAN)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(200):
        drawn = [
            Pairing(
                red=p.red,
                blue=p.blue,
                games=60,
                score=rng.binomial(60, p.score / p.games),
                scenario=p.scenario,
            )
            for p in pairings(60)
        ]
        elo = elo_ratings(drawn).players["strong"]
        held += elo.low <= STRENGTHS["strong"] <= elo.high
    assert 180 <= held <= 198  # 190 are expected


def test_four_times_the_games_halve_the_interval() -> None:
    few, many = (elo_ratings(pairings(games)).players["weak"] for games in (400, 1600))

    assert (few.high - few.low) / (many.high - many.low) == pytest.approx(2.0, rel=0.02)


def test_an_unbeaten_player_has_a_finite_rating() -> None:
    found = elo_ratings(
        [Pairing(red="a", blue="b", games=100, score=100), Pairing(red="b", blue="a", games=100, score=0)]
    )

    elo = found.players["a"]
    assert MEAN < elo.low < elo.value < elo.high < MEAN + 2000


LADDER = (1300.0, 1500.0, 1700.0, 1900.0)  # players whose ratings are known


def results(elo: float, games: int) -> list[Against]:
    """Games of one player that end exactly as its strength says."""
    return [Against(elo=one, games=games, score=games * expected(elo - one)) for one in LADDER]


@pytest.mark.parametrize("elo", [1000.0, 1500.0, 1830.0, 2400.0])
def test_one_player_has_the_rating_that_its_games_were_made_with(elo: float) -> None:
    assert rate_player(results(elo, 1_000_000)).value == pytest.approx(elo, abs=1.0)


def test_one_player_among_many_is_rated_as_they_are_together() -> None:
    """Where the others' ratings are certain, both ways of rating agree."""
    together = elo_ratings(pairings(1_000_000))
    own = [
        Against(
            elo=together.players[p.blue].value - together.red_seat[p.scenario].value,
            games=p.games,
            score=p.score,
        )
        for p in pairings(1_000_000)
        if p.red == "strong" and p.blue != "strong"
    ]

    assert rate_player(own).value == pytest.approx(together.players["strong"].value, abs=0.1)


def test_a_player_without_a_game_is_of_the_mean_and_nobody_knows() -> None:
    elo = rate_player([])

    assert elo.value == pytest.approx(MEAN)
    assert elo.high - elo.low > 900


def test_who_always_wins_or_loses_has_a_finite_rating() -> None:
    best, worst = (rate_player([Against(elo=1900, games=20, score=score)]) for score in (20, 0))

    assert 1900 < best.value < best.high < 3000
    assert 0 < worst.low < worst.value < 1500


def test_a_rating_by_hand() -> None:
    """Against a player of the mean the prior is two more games, a win and a loss: 3 of 4 are 3 to 1, 190.8 points."""
    elo = rate_player([Against(elo=MEAN, games=2, score=2)])

    assert elo.value - MEAN == pytest.approx(400 * np.log10(3))
    assert elo.high - elo.value == pytest.approx(1.959964 * 400 / np.log(10) / np.sqrt(4 * 0.75 * 0.25))


def test_the_order_of_the_games_and_how_they_are_put_together_change_nothing() -> None:
    one = rate_player([Against(elo=1600, games=3, score=2), Against(elo=1400, games=1, score=0.5)])
    games = [Against(elo=1400, score=0.5), *(Against(elo=1600, score=score) for score in (1, 0, 1))]

    assert rate_player(games).value == pytest.approx(one.value)
    assert rate_player(games).high == pytest.approx(one.high)


def test_the_interval_of_one_player_holds_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(400):
        drawn = [Against(elo=one, games=10, score=rng.binomial(10, expected(1650 - one))) for one in LADDER]
        elo = rate_player(drawn)
        held += elo.low <= 1650 <= elo.high
    assert 366 <= held <= 394  # 380 are expected


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"elo": 1500, "games": 0}, "games must be an integer >= 1, got 0"),
        ({"elo": float("nan")}, "elo must be a number of at most 10000 either way, got nan"),
        ({"elo": "1500"}, "elo must be a number, got '1500'"),
        ({"elo": 1500, "score": 1.5}, "score must be in 0..1, the games, got 1.5"),
        ({"elo": 1500, "score": float("nan")}, "score must be in 0..1, the games, got nan"),
    ],
)
def test_results_that_cannot_be_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Against(**values)
