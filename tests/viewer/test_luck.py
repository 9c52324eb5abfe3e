"""Luck of shots: exact chances from the state before, and points that add up."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Shoot
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.play import record_game
from hexwar_sb3.viewer.luck import SHOTS, Loss, judge_shots, points_lost


def judged(replay: Replay) -> list[tuple[Any, Any, Any]]:
    """Every shot of a game with its luck and the pieces before it."""
    found, before = [], None
    for game, events in replay.ticks():
        if before is not None:
            luck = judge_shots(events, before, game.world, game.roster)
            found += [(events[n], one, before) for n, one in luck.items()]
        before = game.pieces.copy()
    return found


@pytest.mark.parametrize("seed", [3, 11])
def test_the_points_of_all_shots_are_the_points_that_were_lost(seed: int) -> None:
    replay = record_game("MA1", "MA2", seed=seed)
    start, last = replay.game_at(0), replay.game_at(1800)

    shots = judged(replay)

    value = start.world.rules[0].value[start.pieces.kind]
    lost = int((value * (start.pieces.blood - last.pieces.blood)).sum())
    assert lost > 0
    assert sum(luck.lost for _, luck, _ in shots) == lost
    assert all(abs(sum(luck.chances.values()) - 1) < 1e-5 for _, luck, _ in shots)
    assert all(luck.chances.get(min(event.result, max(luck.chances)), 0) > 0 for event, luck, _ in shots), (
        "a result that had no chance"
    )


def test_what_is_expected_is_what_comes_of_many_dice() -> None:
    """The mean of a shot's points over many seeds is its expectation, within four standard errors."""
    points, expected, variance = [], 0.0, 0.0
    for seed in range(400):
        game = Game.from_text("map plain-40x3\nred tank 0102\nblue chariot 0502", seed=seed)
        before = game.pieces.copy()
        game.submit("red", Shoot("tank0", "chariot0", "GUN"))
        events = game.advance(1)
        (luck,) = judge_shots(events, before, game.world, game.roster).values()
        points.append(luck.lost)
        expected, variance = luck.expected, luck.variance

    error = np.sqrt(variance / len(points))
    assert abs(np.mean(points) - expected) < 4 * error
    assert abs(np.var(points) - variance) < 0.35 * variance


def test_a_passenger_and_a_suppressed_soldier_are_counted() -> None:
    """Rule book, sections 7 and 13."""
    game = Game("plain", seed=0)
    rules, roster = game.world.rules[0], game.roster
    chariot, rider = roster.index("red:chariot0"), roster.index("red:soldier0")
    value = [int(rules.value[game.pieces[i].kind]) for i in (chariot, rider)]

    assert points_lost(chariot, Loss(1), game.pieces, rules) == sum(value)
    assert points_lost(chariot, Loss(9), game.pieces, rules) == 3 * sum(value)
    soldier = game.pieces.copy()
    soldier[rider].suppressed = 1
    assert points_lost(rider, Loss(0, suppressed=True), soldier, rules) == value[1]
    assert points_lost(rider, Loss(0, suppressed=True), game.pieces, rules) == 0


def test_every_kind_of_shot_is_known() -> None:
    from hexwar_sb3.engine.game_events import _SHOTS

    assert {event.name.lower() for event in _SHOTS} == SHOTS
