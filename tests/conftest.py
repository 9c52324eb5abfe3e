"""What all tests share: kernels are compiled once, before the tests run side by side."""

from __future__ import annotations

import copy
import json
import os
import random
from collections.abc import Callable, Iterator
from typing import Any

import joblib
import numpy as np
import pytest
from joblib.parallel import ThreadingBackend

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.replay_file import content_hash
from hexwar_sb3.rules.enums import Camp


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what nearly every test needs before workers start, so that they do not all compile the same."""
    workers = getattr(session.config.option, "numprocesses", None)
    if workers and "PYTEST_XDIST_WORKER" not in os.environ:
        from hexwar_sb3.envs.prepare import prepare

        prepare(print)


class Elsewhere(ThreadingBackend):  # type: ignore[misc]  # joblib has no types
    """Stands for a cluster: its workers are this process, which they need not know."""


@pytest.fixture
def elsewhere() -> Iterator[None]:
    """Let jobs of `run_jobs` travel."""
    joblib.register_parallel_backend("elsewhere", Elsewhere)
    with joblib.parallel_config("elsewhere"):
        yield


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
    arena.missions[b, side] = arena.missions[b, 0]
    for r in range(state.rounds.shape[1]):
        flying = state.rounds[b, r].camp == enemy and state.rounds[b, r].status != 2
        if flying:
            state.rounds[b, r].cell, state.rounds[b, r].land_at = rng.choice(playable), rng.integers(0, 1800)


@pytest.fixture
def scramble() -> Callable[[Any, int, Camp, np.random.Generator], None]:
    """Function that changes everything in game b of an arena that a camp can neither see nor remember."""
    return scramble_unseen


def told_otherwise(replay: Replay, change: Callable[[list[Any]], object]) -> Replay:
    """The replay with other lines, and the hash that they have."""
    lines = copy.deepcopy([dict(line) for line in replay.lines])
    change(lines)
    return Replay((*lines[:-1], lines[-1] | {"sha256": content_hash(lines[:-1])}))


@pytest.fixture
def changed_replay() -> Callable[[Replay, Callable[[list[Any]], object]], Replay]:
    """Function that changes the lines of a replay, and seals it again."""
    return told_otherwise


@pytest.fixture(scope="session")
def as_person() -> Callable[..., Replay]:
    """Function that says of a game that people played these camps, and, where `named` is False, nothing of bots."""

    def told(replay: Replay, *camps: str, named: bool = True) -> Replay:
        def change(lines: list[Any]) -> None:
            for camp in camps:
                lines[0]["players"][camp]["kind"] = "human"
            if not named:
                lines[0]["players"] = {
                    camp: one | {"name": "Ann"} for camp, one in lines[0]["players"].items()
                }
                lines[:] = [line for line in lines if line["type"] != "decision"]

        return told_otherwise(replay, change)

    return told


SWAPS: tuple[Any, ...] = (None, [], {}, -1, 0.5, 1e308, True, "x", "", 10**39, [[]], {"x": 1}, ["x"] * 3)
"""Values of other kinds, for any place of a document."""
Bad = Callable[[Any], Iterator[bytes]]


def bad_documents(document: Any) -> Iterator[bytes]:
    """Files that are nearly a JSON document: each value of another kind, keys lost, added and doubled, bytes cut and flipped."""
    for place in _places(document):
        for value in SWAPS:
            yield json.dumps(_changed(document, place, value)).encode()
        yield json.dumps(_changed(document, place, _GONE)).encode()
        yield json.dumps(_changed(document, (*place, "another key"), 1)).encode()
    text = json.dumps(document).encode()
    rng = random.Random(0)
    for _ in range(30):
        yield text[: rng.randrange(len(text))]
        flipped = bytearray(text)
        flipped[rng.randrange(len(text))] ^= 1 << rng.randrange(8)
        yield bytes(flipped)
    key = json.dumps(next(iter(document))).encode()
    yield text.replace(b"{", b"{" + key + b": 1, ", 1)
    yield text.replace(b"1", b"NaN", 1)
    yield b"\xff\xfe" + text
    yield b"[" * 100_000


_GONE = object()


def _places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Places of all values; of a list those of the first two entries."""
    entries = (
        value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    )
    for key, one in entries:
        yield (*place, key)
        yield from _places(one, (*place, key))


def _changed(document: Any, place: tuple[Any, ...], value: Any) -> Any:
    """The document with another value in a place, or without it; as it is where there is no such place."""
    new = copy.deepcopy(document)
    inside = new
    for key in place[:-1]:
        inside = inside[key]
    if value is _GONE:
        del inside[place[-1]]
    elif isinstance(inside, dict) or isinstance(place[-1], int):
        inside[place[-1]] = value
    return new


@pytest.fixture
def swaps() -> tuple[Any, ...]:
    """Values of kinds that hardly anything takes."""
    return SWAPS


@pytest.fixture
def bad() -> Bad:
    """Function that makes some hundred bad files of a JSON document."""
    return bad_documents
