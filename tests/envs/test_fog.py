"""Fog: what a camp can neither see nor remember changes none of its observation (rule book, section 6)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.task_games import TaskGames
from hexwar_sb3.rules.enums import Camp

Pick = Callable[[NDArray[Any], int], NDArray[np.int64]]
Scramble = Callable[[Any, int, Camp, np.random.Generator], None]


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_the_unseen_changes_no_byte_of_an_observation(camp: Camp, pick: Pick, scramble: Scramble) -> None:
    """Over whole games, at every decision: obs, tasks, mask and alive stay as they are."""
    settings = TaskSettings(side=camp.name.lower(), opponent="MA1")
    games, rng = TaskGames(2, settings, seed=1), np.random.default_rng(0)
    games.begin(games.all)
    seen_something = False
    for step in range(23):
        obs = {key: value.copy() for key, value in games.look(games.all).items()}
        true_state = games.snapshot()
        for b in games.all:
            scramble(games.arena, int(b), camp, rng)
        again = games.look(games.all)
        assert all(obs[key].tobytes() == again[key].tobytes() for key in obs)
        games.restore(true_state)
        seen_something = seen_something or bool(games.arena.state.memory.seen[:, camp].any())
        games.play(pick(obs["action_mask"], step))
    assert seen_something


def test_lights_on_shows_the_enemy_at_once() -> None:
    dark, light = (TaskGames(1, TaskSettings(fog=fog), seed=0) for fog in (True, False))
    for games in (dark, light):
        games.begin(games.all)
    assert light.look(light.all)["obs"].tobytes() != dark.look(dark.all)["obs"].tobytes()
