"""Matches: many games of one pairing, counted, with intervals."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from pathlib import Path

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.results import CampResult, MatchResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.match import MatchGames, play_games
from hexwar_sb3.play.records import DECISION_TICKS
from hexwar_sb3.players.player import given_name
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.spots import SPOTS

MOST_GAMES = 10_000_000  # of a match


def play_match(
    red: object,
    blue: object,
    games: int = 2000,
    scenario: str | Path | Scenario = "plain",
    seed: int = 0,
    *,
    purpose: Purpose = Purpose.REPORT,
    decision_ticks: int | tuple[int, int] = DECISION_TICKS,
    spots: int = SPOTS,
    early: bool = False,
    progress: Callable[[int], object] | None = None,
) -> MatchResult:
    """Play games between two players and count.

    Args:
        red: a bot's name, a policy folder or run folder, a `FrozenPolicy`, or a model with `predict`.
        blue: likewise.
        games: number of games; game k has the dice of (seed, k), whoever plays.
        scenario: a scenario, its name or its path.
        seed: in 0..999999.
        purpose: shifts the seed into the range that this kind of games has for itself.
        decision_ticks: ticks between two decisions of a policy; or of (red, blue).
        spots: k of G^L(k), the cells that tasks lead to.
        early: policies also decide after an own loss or an ended task.
        progress: called with the number of games played so far, now and then.

    Raises:
        UnknownNameError: no such player or scenario.
        ConfigError: a number is out of range, an object cannot play, or a player does not fit the scenario.

    Example:
        >>> play_match("MA1", "MA2", games=100).win_rate
    """
    check_games(games)
    outcome = play_games(
        red,
        blue,
        games,
        scenario,
        seed_for(purpose, seed),
        decision_ticks=decision_ticks,
        spots=spots,
        early=early,
        progress=progress,
    )
    return MatchResult(
        red_name=player_name(red),
        blue_name=player_name(blue),
        scenario=load_world(scenario).scenario.name,
        seed=seed,
        red=camp_result(outcome, Camp.RED),
        blue=camp_result(outcome, Camp.BLUE),
    )


def check_games(games: object) -> None:
    """Raise ConfigError unless there is a game to play, and their figures fit into memory."""
    if isinstance(games, bool) or not isinstance(games, Integral) or games < 1:
        raise ConfigError(f"games must be at least 1, got {games!r}")
    check_whole("games", games, least=1, most=MOST_GAMES)


def camp_result(outcome: MatchGames, camp: Camp) -> CampResult:
    """What a camp reached in the games of a match."""
    return CampResult(
        scores=outcome.win if camp == Camp.RED else 1.0 - outcome.win,
        margins=outcome.margins[:, camp].astype(np.float64),
        points_held=outcome.points_held[:, camp],
    )


def player_name(player: object) -> str:
    """What tables call a player: its name, its folder's name, or its type."""
    return given_name(player) or str(getattr(player, "name", type(player).__name__))
