"""Elo ratings: known strengths are found again, and what cannot be known has a wide interval."""

from __future__ import annotations

import numpy as np
import pytest

from hexwar_sb3.evaluation.elo import MEAN, Pairing, elo_ratings

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
