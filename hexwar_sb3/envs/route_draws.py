"""Random numbers of the route env's games: one stream for all of them, or one for each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.play.arena import Games


class Draws:
    """Streams of random numbers.

    Args:
        seeds: one for all games, or one a game, whose stream is then that of an env of one game.
        n_games: games side by side.
    """

    def __init__(self, seeds: Sequence[int], n_games: int) -> None:
        games = n_games if len(seeds) == 1 else 1
        self._rngs = [np.random.default_rng([seed, games]) for seed in seeds]

    @property
    def first(self) -> np.random.Generator:
        """The one stream, where there is one."""
        return self._rngs[0]

    def random(self, which: Games, shape: tuple[int, ...]) -> NDArray[np.float64]:
        """Numbers in [0, 1) for these games [n, *shape]."""
        drawn = np.empty((len(which), *shape))
        for rng, at, count in self._parts(which):
            drawn[at] = rng.random((count, *shape))
        return drawn

    def walks(self, which: Games, n_cells: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """For pieces of these games, a game named once a piece: a cell of so many [n], and a number in [0, 1) [n]."""
        cells, shares = np.empty(len(which), np.int64), np.empty(len(which))
        for rng, at, count in self._parts(which):
            cells[at], shares[at] = rng.integers(n_cells, size=count), rng.random(count)
        return cells, shares

    def _parts(self, which: Games) -> Iterator[tuple[np.random.Generator, Any, int]]:
        """Each stream with the rows that it is for, and their number."""
        if len(self._rngs) == 1:
            yield self.first, slice(None), len(which)
            return
        for b in np.unique(which):
            at = np.flatnonzero(which == b)
            yield self._rngs[b], at, len(at)
