"""What all tests share: kernels are compiled once, before the tests run side by side."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.rules.enums import Camp


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what nearly every test needs before workers start, so that they do not all compile the same."""
    workers = getattr(session.config.option, "numprocesses", None)
    if workers and "PYTEST_XDIST_WORKER" not in os.environ:
        from hexwar_sb3.envs.prepare import prepare

        prepare(print)


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


def scramble_unseen(arena: Any, b: int, camp: Camp, rng: np.random.Generator) -> None:
    """Change everything in game b that the camp can neither see nor remember."""
    state, enemy = arena.state, 1 - camp
    game, pieces, side = state.games[b], state.pieces[b], arena.world.side(enemy)
    playable = np.flatnonzero(arena.world.cells.playable)
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
    arena.plans[b, side] = arena.plans[b, 0]
    for r in range(state.rounds.shape[1]):
        flying = state.rounds[b, r].camp == enemy and state.rounds[b, r].status != 2
        if flying:
            state.rounds[b, r].cell, state.rounds[b, r].land_at = rng.choice(playable), rng.integers(0, 1800)


@pytest.fixture
def scramble() -> Callable[[Any, int, Camp, np.random.Generator], None]:
    """Function that changes everything in game b of an arena that a camp can neither see nor remember."""
    return scramble_unseen
