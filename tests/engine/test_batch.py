"""A batch of games (architecture.md, section 2)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.batch import Engine
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Hide, IndirectShoot, Move, Order
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.errors import UnknownNameError

ORDERS: list[Order] = [Move("tank0", ["1134", "1234"]), Hide("tank1"), IndirectShoot("chariot0", "2037")]


@pytest.fixture
def engine() -> Engine:
    engine = Engine("plain", n_games=3)
    engine.reset([5, 6, 7])
    return engine


def test_each_game_takes_its_own_orders(engine: Engine) -> None:
    engine.submit(1, "red", ORDERS)
    engine.advance(200)
    assert [engine.view(b, "red").piece("tank0").cell for b in range(len(engine))] == ["1135", "1234", "1135"]


def test_a_game_in_a_batch_is_the_game_alone(engine: Engine) -> None:
    game = Game("plain", seed=6)
    game.submit("red", ORDERS)
    game.advance(321)
    engine.submit(1, "red", ORDERS)
    for ticks in (1, 20, 300):
        engine.advance(ticks)
    assert state_hash(engine.snapshot(1), 0) == state_hash(game.state, 0)
    assert list(engine.margins("red")) == [-130, -130, -130]


def test_a_snapshot_brings_a_game_back(engine: Engine) -> None:
    """Snapshots are record copies of at most 4 KB."""
    engine.advance(10)
    snapshot = engine.snapshot(0)
    engine.submit(0, "red", ORDERS)
    engine.advance(50)
    moved = state_hash(engine.snapshot(0), 0)
    engine.restore(0, snapshot)
    engine.submit(0, "red", ORDERS)
    engine.advance(50)
    assert state_hash(engine.snapshot(0), 0) == moved
    arrays = (snapshot.games, snapshot.pieces, snapshot.memory, snapshot.paths, snapshot.rounds)
    assert sum(array.nbytes for array in arrays) <= 4096 + snapshot.paths.nbytes


def test_all_games_end(engine: Engine) -> None:
    engine.advance(5000)
    assert engine.state.games.over.all()
    assert (engine.state.games.tick == 1800).all()


def test_an_unknown_scenario_has_a_hint() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'hills'"):
        Engine("hill")
