"""Matches: many games of one pairing, counted, with intervals."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.results import CampResult, MatchResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.match import MatchGames, play_games
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.player import Player, given_name, make_player
from hexwar_sb3.players.terms import USUAL, Terms, checked_settings, trained_terms
from hexwar_sb3.rules.enums import Camp

CAMPS = ("red", "blue")
MOST_GAMES = 10_000_000  # of a match


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """How players are measured: what all cells of a table have in common."""

    terms: Terms = USUAL
    games: int = 2000  # a cell
    seed: int = 0  # the user's, shifted into the range of the purpose
    purpose: Purpose = Purpose.REPORT
    camps: tuple[str, ...] = CAMPS  # that the player takes

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is out of its range.
        """
        check_games(self.games)
        seed_for(self.purpose, self.seed)

    def play(
        self,
        red: object,
        blue: object,
        decision_ticks: tuple[int, int] | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> MatchResult:
        """Play one cell and count.

        Args:
            red: a bot's name, a policy folder or run folder, a `FrozenPolicy`, or a model with `predict`.
            blue: likewise.
            decision_ticks: between decisions of (red, blue), where they differ from the terms.
            progress: called with the number of games played so far, now and then.
        """
        seed = seed_for(self.purpose, self.seed)
        outcome = play_games(
            red, blue, self.games, self.terms, seed, decision_ticks=decision_ticks, progress=progress
        )
        return MatchResult(
            red_name=player_name(red),
            blue_name=player_name(blue),
            scenario=load_world(self.terms.scenario).scenario.name,
            seed=self.seed,
            red=camp_result(outcome, Camp.RED),
            blue=camp_result(outcome, Camp.BLUE),
        )

    def play_as(self, camp: str, player: object, opponent: object) -> CampResult:
        """Play one cell, and return what the player of this camp reached; the opponent decides as it was trained."""
        own, its = self.terms.decision_ticks, trained_terms(opponent, self.terms).decision_ticks
        if camp == "red":
            return self.play(player, opponent, (own, its)).red
        return self.play(opponent, player, (its, own)).blue

    def check_opponents(self, opponents: Iterable[object]) -> None:
        """Let opponents look at the first position, before games are played that would only lead there.

        Raises:
            ConfigError: one does not fit the scenario or these terms; and as `make_player`.
        """
        self.check_fit(opponents, [CAMPS[1 - CAMPS.index(camp)] for camp in self.camps])

    def check_fit(self, players: Iterable[object], camps: Iterable[str] = CAMPS) -> None:
        """Let players look at the first position of each of these camps.

        Raises:
            ConfigError: one does not fit; and as `make_player`.
        """
        arena = Arena(load_world(self.terms.scenario), 1, self.terms)
        for player in players:
            seat = make_player(player)
            for camp in camps:
                if isinstance(seat, Player):
                    seat.reset()
                try:
                    arena.begin(0, 0, *(seat if one == camp else None for one in CAMPS))
                    arena.ask([0])
                except ConfigError as error:
                    raise ConfigError(
                        f"{player_name(player)} as {camp} on {self.terms.scenario}: {error}"
                    ) from error

    def record(
        self,
        red: object,
        blue: object,
        episode: int = 0,
        decision_ticks: tuple[int, int] | None = None,
        names: tuple[str, str] | None = None,
        command: str | None = None,
    ) -> Replay:
        """Play one game of a cell, by its number, and write it down; further arguments as `record_game`."""
        seed = seed_for(self.purpose, self.seed)
        more: dict[str, Any] = {"decision_ticks": decision_ticks, "names": names, "command": command}
        return record_game(red, blue, self.terms, seed, episode=episode, **more)


def play_match(
    red: object,
    blue: object,
    games: int = 2000,
    seed: int = 0,
    *,
    progress: Callable[[int], object] | None = None,
    **terms: Any,
) -> MatchResult:
    """Play games between two players and count.

    Args:
        red: a bot's name, a policy folder or run folder, a `FrozenPolicy`, or a model with `predict`.
        blue: likewise.
        games: number of games; game k has the dice of (seed, k), whoever plays.
        seed: in 0..999999.
        progress: called with the number of games played so far, now and then.
        terms: of the games, as `Terms` has them: scenario, decision_ticks, decisions, spots, fog.

    Raises:
        UnknownNameError: no such player or scenario.
        UnknownSettingError: no such setting.
        ConfigError: a number is out of range, an object cannot play, or a player does not fit the scenario.

    Example:
        >>> result = play_match("MA1", "MA2", games=20, scenario="hills")
        >>> result.win_rate.percent()
        '60.0 % [38.7, 78.1]'
        >>> result.wins, result.draws, result.losses  # red's
        (12, 0, 8)
    """
    how = Evaluation(terms=checked_settings(Terms, terms), games=games, seed=seed)
    return how.play(red, blue, progress=progress)


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
