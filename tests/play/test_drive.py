"""The drive loop: the same game however it is cut, batched or resumed (architecture.md, section 2)."""

from __future__ import annotations

import numpy as np
import pytest

from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.match import play_games
from hexwar_sb3.play.records import EARLY_TICKS
from hexwar_sb3.play.seeds import game_seed
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action, Camp

GAMES = 3
RED, BLUE = "MA1", "MA2"
PLAIN = Terms()


@pytest.fixture(scope="module")
def world() -> World:
    return load_world("plain")


def seated(world: World, n_games: int, terms: Terms = PLAIN) -> Arena:
    arena = Arena(world, n_games, terms)
    for b in range(n_games):
        arena.begin(b, game_seed(0, b), make_player(RED), make_player(BLUE))
    return arena


def played_out(arena: Arena) -> Arena:
    which = np.arange(arena.n_games)
    while which.size:
        arena.advance(which)
        which = which[~arena.over(which)]
    return arena


def same_game(one: Arena, b: int, other: Arena, other_b: int) -> bool:
    """Equal in every field: state and missions of a game in two arenas."""
    names = ("games", "pieces", "memory", "paths", "rounds", "missions", "brains")
    one_rows, other_rows = one.snapshot(), other.snapshot()
    return all(np.array_equal(one_rows[name][b], other_rows[name][other_b]) for name in names)


def test_a_game_alone_is_the_same_game_in_a_batch(world: World) -> None:
    together = played_out(seated(world, GAMES))
    for b in range(GAMES):
        alone = Arena(world, 1, PLAIN)
        alone.begin(0, game_seed(0, b), make_player(RED), make_player(BLUE))
        assert same_game(played_out(alone), 0, together, b)


@pytest.mark.parametrize("ticks", [1, 7, 60])
def test_a_game_is_the_same_at_every_chunk_size(world: World, ticks: int) -> None:
    whole = played_out(seated(world, GAMES))
    cut = seated(world, GAMES, Terms(decision_ticks=ticks))
    cut.drives.asked[:] = 1

    played_out(cut)

    assert all(same_game(whole, b, cut, b) for b in range(GAMES))


def test_a_restored_game_goes_on_as_before(world: World) -> None:
    arena = seated(world, GAMES, Terms(decision_ticks=500))
    arena.drives.asked[:] = 1
    arena.advance(np.arange(GAMES))
    snapshot = arena.snapshot()
    end = played_out(arena).snapshot()

    other = seated(world, GAMES)
    other.restore(snapshot)

    assert all(np.array_equal(end[name], array) for name, array in played_out(other).snapshot().items())


def test_a_game_ends_at_its_last_tick(world: World) -> None:
    arena = played_out(seated(world, GAMES))
    assert (arena.state.games.tick == world.scenario.game_ticks).all()


def test_early_decisions_come_after_own_losses(world: World) -> None:
    """decisions="event": whoever lost blood decides before the next multiple of Delta-t."""
    arena = seated(world, 1, Terms(decision_ticks=75, decisions="event"))
    arena.drives.asked[0, Camp.RED] = 1
    one, game, drive, early = np.zeros(1, np.int64), arena.state.games[0], arena.drives[0], 0
    while not arena.over(one)[0]:
        drive.ended[Camp.RED] = 0xFFFFFFFF  # no task calls
        arena.advance(one)
        decided_at, drive.decided_at[Camp.RED] = int(drive.decided_at[Camp.RED]), game.tick
        if arena.due(one, Camp.RED)[0] and game.tick % 75:
            early += 1
            assert game.loss_tick[Camp.RED] > decided_at
            assert game.tick >= decided_at + EARLY_TICKS
    assert early > 0


def test_a_match_gives_each_game_its_row() -> None:
    """Game k of a match depends on seed and k alone, and every camp's orders are counted."""
    few, more = play_games(RED, BLUE, 2, seed=3), play_games(RED, BLUE, 4, seed=3)

    assert (few.margin == more.margin[:2]).all()
    assert (few.actions == more.actions[:2]).all()
    assert (more.actions[:, :, Action.MOVE] > 0).all()
    assert (more.actions[:, :, Action.NULL] == 0).all()
    assert set(more.win) <= {0.0, 0.5, 1.0}
