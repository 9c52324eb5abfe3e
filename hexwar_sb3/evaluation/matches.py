"""Matches: many games of one pairing, each with its own seed, played in batches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.results import CampResult, MatchResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.arena import Arena, Setup
from hexwar_sb3.play.player import make_player
from hexwar_sb3.play.records import DECISION_TICKS
from hexwar_sb3.play.seeds import game_seed
from hexwar_sb3.rules.enums import Camp

BATCH_GAMES = 256  # games played side by side; the result does not depend on it


def play_match(
    red: object,
    blue: object,
    games: int = 2000,
    scenario: str | Path | Scenario = "plain",
    seed: int = 0,
    *,
    purpose: Purpose = Purpose.REPORT,
    decision_ticks: int = DECISION_TICKS,
    batch_games: int = BATCH_GAMES,
) -> MatchResult:
    """Play games between two players and count.

    Args:
        red: a bot's name, a policy folder or run folder, a `FrozenPolicy`, or a model with `predict`.
        blue: likewise.
        games: number of games; game k has the dice of (seed, k), whoever plays.
        scenario: a scenario, its name or its path.
        seed: in 0..999999.
        purpose: shifts the seed into the range that this kind of games has for itself.
        decision_ticks: ticks between two decisions of a policy.
        batch_games: games side by side.

    Raises:
        UnknownNameError: no such player or scenario.
        ConfigError: a number is out of range, or an object cannot play.

    Example:
        >>> play_match("MA1", "MA2", games=100).win_rate
    """
    if games < 1:
        raise ConfigError(f"games must be at least 1, got {games}")
    world = load_world(scenario)
    seats = make_player(red), make_player(blue)
    first_seed = seed_for(purpose, seed)
    arena = Arena(world, min(games, batch_games), Setup(decision_ticks=(decision_ticks, decision_ticks)))
    camps: tuple[list[CampResult], list[CampResult]] = ([], [])
    for episodes in _batches(games, arena.n_games):
        for b, episode in enumerate(episodes):
            arena.begin(b, game_seed(first_seed, episode), *seats)
        play_out(arena, len(episodes))
        for camp in (Camp.RED, Camp.BLUE):
            camps[camp].append(result_of(arena, camp, len(episodes)))
    return MatchResult(
        red_name=player_name(red),
        blue_name=player_name(blue),
        scenario=world.scenario.name,
        seed=seed,
        red=CampResult.joined(camps[Camp.RED]),
        blue=CampResult.joined(camps[Camp.BLUE]),
    )


def play_out(arena: Arena, games: int) -> None:
    """Play the first `games` games of an arena to their ends."""
    running = np.arange(games)
    while running.size:
        arena.ask(running)
        arena.advance(running)
        running = running[~arena.over(running)]


def result_of(arena: Arena, camp: Camp, games: int) -> CampResult:
    """What a camp reached in the first `games` games of an arena."""
    which = np.arange(games)
    camps = np.full(games, camp)
    return CampResult(
        scores=arena.wins(which, camps),
        margins=arena.margins(which, camps).astype(np.float64),
        points_held=np.array([arena.points_held(b, camp) for b in which]),
    )


def player_name(player: object) -> str:
    """What tables call a player: its name, its folder's name, or its type."""
    if isinstance(player, str | Path):
        return Path(player).name
    return str(getattr(player, "name", type(player).__name__))


def _batches(games: int, size: int) -> Iterator[range]:
    for start in range(0, games, size):
        yield range(start, min(start + size, games))
