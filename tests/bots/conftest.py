"""Games between scripted players that stop where a player is about to think."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.seeds import game_seed
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms


class BotGames:
    """A batch of games between two bots."""

    def __init__(self, red: str, blue: str, scenario: str = "plain", games: int = 1) -> None:
        self.arena = Arena(load_world(scenario), games, Terms())
        for b in range(games):
            self.arena.begin(b, game_seed(0, b), make_player(red), make_player(blue))

    def thoughts(self) -> Iterator[int]:
        """Play game 0, and stop at every tick at which both players are about to think."""
        self.arena.drives.asked[0] = 1
        while not self.arena.over(np.array([0]))[0]:
            yield int(self.arena.state.games.tick[0])
            self.arena.advance(np.array([0]))

    def played_out(self) -> BotGames:
        """Play all games to their end."""
        which = np.arange(self.arena.n_games)
        while which.size:
            self.arena.advance(which)
            which = which[~self.arena.over(which)]
        return self

    def margins(self, camp: int) -> list[int]:
        which = np.arange(self.arena.n_games)
        return [int(margin) for margin in self.arena.margins(which, np.full(which.size, camp))]


@pytest.fixture
def bot_games() -> Callable[..., BotGames]:
    return BotGames
