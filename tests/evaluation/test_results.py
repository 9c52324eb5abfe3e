from __future__ import annotations

import json

import numpy as np
import pytest

from hexwar_sb3.evaluation.results import CampResult, MatchResult


def camp(scores: list[float], margins: list[float], points: list[int]) -> CampResult:
    return CampResult(np.array(scores), np.array(margins), np.array(points))


RED = camp([1, 1, 0.5, 0], [40, 20, 0, -60], [2, 1, 0, 0])
BLUE = camp([0, 0, 0.5, 1], [-40, -20, 0, 60], [0, 1, 0, 2])


def test_a_draw_counts_half_and_all_three_are_told() -> None:
    """Win rate = (wins + draws / 2) / games, all three printed."""
    assert (RED.wins, RED.draws, RED.losses) == (2, 1, 1)
    assert RED.win_rate.value == 0.625


def test_the_mean_margin_is_in_points() -> None:
    assert RED.mean_margin.value == 0.0
    assert RED.mean_margin.low < 0 < RED.mean_margin.high


def test_points_held_are_shares_of_the_games() -> None:
    assert RED.points_shares == (0.5, 0.25, 0.25)


def test_both_colours_can_be_joined() -> None:
    both = CampResult.joined([RED, BLUE])

    assert both.games == 8
    assert both.win_rate.value == pytest.approx(0.5)


def test_the_summary_is_json() -> None:
    match = MatchResult(red_name="a", blue_name="b", scenario="plain", seed=0, red=RED, blue=BLUE)

    assert json.loads(json.dumps(match.summary()))["red"]["wins"] == match.wins == 2
    assert "2 won, 1 drawn, 1 lost" in str(match)
