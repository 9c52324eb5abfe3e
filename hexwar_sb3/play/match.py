"""Many games between two players: what happened in each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.play.arena import Arena, Games
from hexwar_sb3.play.records import DRIVE
from hexwar_sb3.play.seeds import check_seed, game_seed
from hexwar_sb3.players.fit import check_fit
from hexwar_sb3.players.player import Player, Seat, given_name, make_player
from hexwar_sb3.players.terms import USUAL, Terms
from hexwar_sb3.rules.enums import Camp

BATCH_GAMES = 64  # played together; no result depends on it


@dataclass(frozen=True)
class MatchGames:
    """Outcome of every game of a match; a row is a game."""

    margins: NDArray[np.int64]  # eq. (1), points [games, camp]; with green points they do not sum to 0
    win: NDArray[np.float64]  # 1 red won, 0.5 draw, 0 blue won [games]
    points_held: NDArray[np.int64]  # control points at the end [games, camp]
    owners: NDArray[
        np.int8
    ]  # who holds each control point at the end, GREEN if nobody ever took it [games, points]
    ticks: NDArray[np.int64]  # length [games]
    actions: NDArray[np.int64]  # orders carried out [games, camp, Action]

    @property
    def margin(self) -> NDArray[np.int64]:
        """Red's margins, points [games]."""
        return self.margins[:, Camp.RED]


def play_games(
    red: object,
    blue: object,
    games: int,
    terms: Terms = USUAL,
    seed: int = 0,
    *,
    decision_ticks: tuple[int, int] | None = None,
    progress: Callable[[int], object] | None = None,
) -> MatchGames:
    """Play games 0..games-1 of a seed; game k is the same game in every match with these players.

    Args:
        red, blue: players as `make_player` takes them.
        games: number of games.
        terms: of the games.
        seed: of the match.
        decision_ticks: between decisions of (red, blue), where they differ from the terms.
        progress: called with the number of games that have ended, now and then.

    Raises:
        UnknownNameError: no such player or scenario.
        ConfigError: a number is out of its range, or a player does not fit the scenario.
    """
    check_seed(seed)
    check_whole("games", games, least=0)
    seats = make_player(red), make_player(blue)
    arena = Arena(load_world(terms.scenario), min(games, BATCH_GAMES), terms, decision_ticks)
    results = _empty(games, len(arena.world.scenario.points))
    for camp, (player, seat) in enumerate(zip((red, blue), seats, strict=True)):
        check_fit(seat, arena.world, camp, given_name(player))
    for first in range(0, games, BATCH_GAMES):
        which = np.arange(min(BATCH_GAMES, games - first))
        _play_batch(arena, which, seats, [game_seed(seed, first + int(b)) for b in which])
        _record(arena, which, results, first)
        if progress is not None:
            progress(first + len(which))
    return results


def _play_batch(arena: Arena, which: Games, seats: tuple[Seat, Seat], seeds: list[int]) -> None:
    for seat in seats:
        if isinstance(seat, Player):
            seat.reset()
    for b in which:
        arena.begin(int(b), seeds[b], *seats)
    while which.size:
        arena.ask(which)
        arena.advance(which)
        which = which[~arena.over(which)]


def _empty(games: int, points: int) -> MatchGames:
    n_actions = DRIVE["actions"].shape[1]
    return MatchGames(
        margins=np.zeros((games, 2), np.int64),
        win=np.zeros(games),
        points_held=np.zeros((games, 2), np.int64),
        owners=np.zeros((games, points), np.int8),
        ticks=np.zeros(games, np.int64),
        actions=np.zeros((games, 2, n_actions), np.int64),
    )


def _record(arena: Arena, which: Games, results: MatchGames, first: int) -> None:
    rows = first + which
    results.win[rows] = arena.wins(which, np.full(len(which), Camp.RED))
    results.ticks[rows] = arena.state.games.tick[which]
    results.owners[rows] = arena.state.games.point_owner[which, : results.owners.shape[1]]
    results.actions[rows] = arena.drives.actions[which]
    for camp in (Camp.RED, Camp.BLUE):
        results.margins[rows, camp] = arena.margins(which, np.full(len(which), camp))
    for b in which:
        results.points_held[first + b] = [arena.points_held(b, camp) for camp in (Camp.RED, Camp.BLUE)]
