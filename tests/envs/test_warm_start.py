"""Warm starts: pieces begin to decide near the hot spots (III-C)."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.task_games import TaskGames
from hexwar_sb3.play.warm_start import WARM_TICKS, hull_cells
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.spots import load_spots


def test_the_hull_holds_the_hot_spots_and_no_lake() -> None:
    world = load_world("plain")
    for camp in (Camp.RED, Camp.BLUE):
        cells = set(hull_cells(world, camp).tolist())
        assert cells.issuperset(load_spots(world)[camp].tolist())
        assert world.cells.passable[sorted(cells)].all()


def test_the_learner_begins_to_decide_after_the_way() -> None:
    games = TaskGames(2, TaskSettings(warm_start=1.0, opponent="random"), seed=0)
    games.begin(games.all)
    assert (games.arena.state.games.tick > WARM_TICKS - games.settings.decision_ticks).all()
    assert games.arena.due(games.all, games.camps).all()
    assert (games.play(np.zeros((2, 7), np.int64)).ticks == games.settings.decision_ticks).all()


def test_only_a_share_of_the_episodes_is_warm() -> None:
    games = TaskGames(12, TaskSettings(warm_start=0.5, opponent="random"), seed=0)
    games.begin(games.all)
    warm = games.arena.state.games.tick > 0
    assert 0 < warm.sum() < 12
