"""Every red player against every blue player."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.evaluation.results import CampResult, MatchResult
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.maps.scenario import Scenario


@dataclass(frozen=True, eq=False)
class RoundRobin:
    """The matches of all pairings, by the names of red and blue."""

    matches: Mapping[tuple[str, str], MatchResult]

    def of_red(self, name: str) -> CampResult:
        """All games of a red player, joined."""
        return CampResult.joined(match.red for (red, _), match in self.matches.items() if red == name)

    def of_blue(self, name: str) -> CampResult:
        """All games of a blue player, joined."""
        return CampResult.joined(match.blue for (_, blue), match in self.matches.items() if blue == name)


def play_round_robin(
    reds: Mapping[str, object],
    blues: Mapping[str, object],
    games: int,
    scenario: str | Path | Scenario = "plain",
    seed: int = 0,
    *,
    purpose: Purpose = Purpose.REPORT,
) -> RoundRobin:
    """Play every red player against every blue one, on the same seeds each time.

    Args:
        reds: players by name.
        blues: likewise.
        games: games a pairing.
        scenario: a scenario, its name or its path.
        seed: in 0..999999.
        purpose: what the games are for; games that select are never the reported ones.
    """
    matches = {
        (red, blue): play_match(reds[red], blues[blue], games, scenario, seed, purpose=purpose)
        for red in reds
        for blue in blues
    }
    return RoundRobin(matches)
