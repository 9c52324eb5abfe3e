"""Acceptance of the scripted players (bots.md, section 4): `python -m hexwar_sb3.evaluation.acceptance`.

Every pairing of MA1 and MA2 with the simpler players and with each other is played on each built-in
map, in both colours; what misses its bar is listed under `failures`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.matches import CAMPS
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import MatchGames, play_games
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action, Camp

FULL_PLAYERS = ("MA1", "MA2")
LEAST_WINS = {"random": 0.95, "nearest": 0.80, **dict.fromkeys(CONSTANT_PLANS, 0.65)}  # by opponent
EVEN = (0.35, 0.65)  # MA1 against MA2
COLOUR_SLACK = 0.02  # of a player against itself, around one half
LEAST_TAKEN = 0.80  # of the games of MA1 against MA2 in which each control point is taken
FIRST_GAMES = 10  # whose margins are kept, to see later that the players are still the same
LEAST_USED = 0.01  # of a player's games in which it uses an action


@dataclass(frozen=True, kw_only=True)
class Accept:
    """Measure MA1 and MA2 against the bars of their design; exit code 1 if one is missed."""

    games: int = 2000  # a pairing and colour; twice as many of a player against itself
    seed: int = 0
    scenarios: tuple[str, ...] = STANDARD
    out: Path | None = None  # JSON file

    def run(self) -> int:
        """Play, then print or write the figures."""
        maps = {name: self.accept(name) for name in self.scenarios}
        failures = [f"{name}: {failure}" for name, found in maps.items() for failure in found["failures"]]
        figures = {"games": self.games, "seed": self.seed, "failures": failures, "maps": maps}
        text = json.dumps(figures, indent=1) + "\n"
        put_out(text, self.out)
        return 1 if failures else 0

    def accept(self, scenario: str) -> dict[str, Any]:
        """Figures of one map."""
        rows: list[dict[str, Any]] = []
        used = {player: np.zeros(len(Action)) for player in FULL_PLAYERS}
        counted = dict.fromkeys(FULL_PLAYERS, 0)
        for red, blue in pairings():
            games = self.games * (2 if red == blue else 1)
            outcome = play_games(
                red, blue, games, Terms(scenario=scenario), seed_for(Purpose.REPORT, self.seed)
            )
            rows.append(figures_of(red, blue, outcome))
            for camp, player in ((Camp.RED, red), (Camp.BLUE, blue)):
                if player in FULL_PLAYERS:
                    used[player] += (outcome.actions[:, camp] > 0).sum(axis=0)
                    counted[player] += games
        shares = {
            player: {action.name: used[player][action] / counted[player] for action in Action if action}
            for player in FULL_PLAYERS
        }
        return {
            **provenance(scenario),
            "failures": [*failures_of(rows), *unused(shares)],
            "used": shares,
            "rows": rows,
        }


def put_out(text: str, path: Path | None) -> None:
    """Write a text to a file, whole or not at all; without one, print it."""
    if path is None:
        sys.stdout.write(text)
        return
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def pairings() -> Iterator[tuple[str, str]]:
    """Red and blue of every pairing."""
    for player in FULL_PLAYERS:
        yield player, player
        for opponent in (*LEAST_WINS, "defender"):
            yield player, opponent
            yield opponent, player
    yield FULL_PLAYERS
    yield FULL_PLAYERS[1], FULL_PLAYERS[0]


def figures_of(red: str, blue: str, outcome: MatchGames) -> dict[str, Any]:
    """One row: red's win rate with its interval, its mean margin, shares of the points taken by anybody."""
    rate = wilson(float(outcome.win.sum()), outcome.win.size)
    return {
        "red": red,
        "blue": blue,
        "games": outcome.win.size,
        "win_rate": rate.value,
        "interval": [rate.low, rate.high],
        "draws": float((outcome.win == 0.5).mean()),
        "mean_margin": float(outcome.margin.mean()),
        "points_held": outcome.points_held.mean(axis=0).tolist(),
        "first_margins": outcome.margin[:FIRST_GAMES].tolist(),
        "taken": (outcome.owners != Camp.GREEN).mean(axis=0).tolist(),
    }


def failures_of(rows: list[dict[str, Any]]) -> list[str]:
    """Say which pairings miss their bar."""
    missed = []
    for row in rows:
        red, blue, rate = row["red"], row["blue"], row["win_rate"]
        wins = dict(zip(CAMPS, (rate, 1 - rate), strict=True))
        if red == blue and abs(rate - 0.5) > COLOUR_SLACK:
            missed.append(f"{red} against itself wins {rate:.3f} as red")
        if {red, blue} == set(FULL_PLAYERS):
            if not EVEN[0] <= rate <= EVEN[1]:
                missed.append(f"{red} wins {rate:.3f} against {blue}")
            missed += [
                f"point {k} is taken in {share:.3f} of the games"
                for k, share in enumerate(row["taken"])
                if share < LEAST_TAKEN
            ]
        for camp, player, opponent in (("red", red, blue), ("blue", blue, red)):
            if player in FULL_PLAYERS and wins[camp] < LEAST_WINS.get(opponent, 0.0):
                missed.append(f"{player} as {camp} wins {wins[camp]:.3f} against {opponent}")
    return missed


def unused(shares: dict[str, dict[str, float]]) -> list[str]:
    """Say which actions a player hardly uses."""
    return [
        f"{player} uses {action} in {share:.4f} of its games"
        for player, actions in shares.items()
        for action, share in actions.items()
        if share < LEAST_USED
    ]


if __name__ == "__main__":
    sys.exit(tyro.cli(Accept).run())
