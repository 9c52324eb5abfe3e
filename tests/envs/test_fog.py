"""Fog: what a camp can neither see nor remember changes none of its observation (rule book, section 6)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.engine.roster import enemy_of
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.task_games import TaskGames
from hexwar_sb3.rules.enums import Camp

Pick = Callable[[NDArray[Any], int], NDArray[np.int64]]

SECRET_FIELDS = (
    "ammo",
    "cool_ends",
    "mortar_ends",
    "keep_ends",
    "hide_ends",
    "board_ends",
    "decompress_ends",
    "sees",
)
UNSEEN_FIELDS = (*SECRET_FIELDS, "blood", "hidden", "suppressed", "path_len", "arrives_at", "stop_ends")


def scramble(games: TaskGames, b: int, camp: Camp, rng: np.random.Generator) -> None:
    """Change everything in game b that the camp can neither see nor remember."""
    state, enemy = games.arena.state, enemy_of(camp)
    game, pieces, side = state.games[b], state.pieces[b], games.arena.world.side(enemy)
    playable = np.flatnonzero(games.arena.world.cells.playable)
    for j in range(side.start, side.stop):
        seen = state.memory[b, camp, j].seen
        if not seen:
            pieces[j].cell = rng.choice(playable)
        for field in SECRET_FIELDS if seen else UNSEEN_FIELDS:
            pieces[j][field] = rng.integers(0, 3, np.shape(pieces[j][field]))
    game.seed = rng.integers(0, 2**63)
    game.salt = rng.integers(0, 2**63, 2)
    game.loss_tick[enemy], game.contact_tick[enemy] = rng.integers(0, 100, 2)
    state.memory[b, enemy] = state.memory[b, camp]
    state.paths[b, side] = 3
    games.arena.plans[b, side] = games.arena.plans[b, 0]
    for r in range(state.rounds.shape[1]):
        flying = state.rounds[b, r].camp == enemy and state.rounds[b, r].status != 2
        if flying:
            state.rounds[b, r].cell, state.rounds[b, r].land_at = rng.choice(playable), rng.integers(0, 1800)


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_the_unseen_changes_no_byte_of_an_observation(camp: Camp, pick: Pick) -> None:
    """Over whole games, at every decision: obs, tasks, mask and alive stay as they are."""
    settings = TaskSettings(side=camp.name.lower(), opponent="MA1")
    games, rng = TaskGames(2, settings, seed=1), np.random.default_rng(0)
    games.begin(games.all)
    seen_something = False
    for step in range(23):
        obs = {key: value.copy() for key, value in games.look(games.all).items()}
        true_state = games.snapshot()
        for b in games.all:
            scramble(games, int(b), camp, rng)
        again = games.look(games.all)
        assert all(obs[key].tobytes() == again[key].tobytes() for key in obs)
        games.restore(true_state)
        seen_something = seen_something or bool(games.arena.state.memory.seen[:, camp].any())
        games.play(pick(obs["action_mask"], step))
    assert seen_something


def test_lights_on_shows_the_enemy_at_once() -> None:
    dark, light = (TaskGames(1, TaskSettings(fog=fog)) for fog in (True, False))
    for games in (dark, light):
        games.begin(games.all)
    assert light.look(light.all)["obs"].tobytes() != dark.look(dark.all)["obs"].tobytes()
