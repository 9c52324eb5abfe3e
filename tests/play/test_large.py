"""The largest games: 64 pieces a side on 250 x 250 cells, 16 points, as true as small ones."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.sight import look_all
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.maps.geometry import playable_mask
from hexwar_sb3.maps.hexmap import LAYERS, HexMap
from hexwar_sb3.maps.scenario import MAX_CONTROL_POINTS, MAX_SIDE_PIECES, ControlPoint, PieceStart, Scenario
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Camp, PieceType

SIDE = 250  # cells
LINE_UP = 6 * (PieceType.TANK, PieceType.CHARIOT, PieceType.AEROCRAFT)


@cache
def large(n: int = MAX_SIDE_PIECES, apart: int = 20) -> Scenario:
    """Two camps of n pieces that stand opposite each other in the middle of a flat map."""
    playable = playable_mask(SIDE, SIDE)
    flat = {name: np.zeros((SIDE, SIDE), np.bool_) for name in LAYERS}
    places = [(SIDE // 2 - n // 2 + 2 * k, SIDE // 2) for k in range(MAX_CONTROL_POINTS)]
    flat["controllable"][tuple(zip(*places, strict=True))] = True
    layers: dict[str, Any] = {**flat, "passable": playable}
    hexmap = HexMap(name="flat", grade_m=10, elev_m=np.zeros((SIDE, SIDE), np.int16), **layers)
    middle, top = SIDE // 2, SIDE // 2 - n // 2
    kinds = [LINE_UP[k % len(LINE_UP)] for k in range(n)]
    pieces = [
        PieceStart(
            camp=camp,
            name=f"{kind.name.lower()}{kinds[:k].count(kind)}",
            kind=kind,
            cell=(top + k) * SIDE + middle + (apart // 2 if camp == Camp.BLUE else -apart // 2),
        )
        for camp in (Camp.RED, Camp.BLUE)
        for k, kind in enumerate(kinds)
    ]
    points = [
        ControlPoint(name=f"point{k}", cell=y * SIDE + x, value=10 + k) for k, (y, x) in enumerate(places)
    ]
    return Scenario(name="large", hexmap=hexmap, pieces=tuple(pieces), points=tuple(points), game_ticks=1_000)


@pytest.fixture(scope="module")
def replay() -> Replay:
    return record_game("MA1", "MA2", Terms(scenario=large()), seed=3)


def test_the_largest_game_is_a_real_one(replay: Replay) -> None:
    kinds = {line["kind"] for line in replay.events}
    assert {"shot", "dead", "occupied", "arrived"} <= kinds


def test_it_verifies_from_its_file(replay: Replay, tmp_path: Path) -> None:
    replay.save(tmp_path / "large.hwr")
    loaded = Replay.load(tmp_path / "large.hwr")
    loaded.verify()
    assert loaded.end == replay.end


def test_all_128_pieces_see_and_are_seen() -> None:
    """Bits of the last slots, and of no other."""
    game = Game(large())
    pieces = game.state.pieces[0]
    last = np.flatnonzero(pieces.slot == MAX_SIDE_PIECES - 1)
    assert pieces.camp[last].tolist() == [Camp.RED, Camp.BLUE]
    for one, other in (last, last[::-1]):
        assert int(pieces[one].sees) >> int(pieces[other].slot) & 1
    own = game.view("red").own
    assert len({name for piece in own for name in piece.sees}) > MAX_SIDE_PIECES // 2


def test_what_is_seen_is_renewed_as_it_changes() -> None:
    arena = Arena(load_world(large()), 1, Terms(scenario=large()))
    arena.begin(0, 5, make_player("MA1"), make_player("MA2"))
    arena.advance(np.arange(1))
    pieces, found = arena.state.pieces[0], arena.state.pieces[0].sees.copy()
    look_all(pieces, *arena.world.tables)
    assert (pieces.sees == found).all()


def test_a_learner_sees_and_acts_in_it() -> None:
    env = make_vec_env(n_envs=2, scenario=large(20), opponent="MA1", seed=1)
    obs: Any = env.reset()
    assert obs["obs"].shape[:2] == (2, 20)
    for _ in range(3):
        actions = obs["action_mask"].argmax(axis=-1)
        obs, rewards, *_ = env.step(actions)
    assert all(np.isfinite(values).all() for values in obs.values())
    assert np.isfinite(rewards).all()
