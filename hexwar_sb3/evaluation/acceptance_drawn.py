"""Acceptance of the drawn families: `python -m hexwar_sb3.evaluation.acceptance_drawn --out FILE`.

Members 1, 2, ... of each family play against "nearest" in both colours, and against "random": none is to be trivial
as a family, and a good share of each is to be a real opponent. Those that weigh or have timetables use every order;
constant plans need not, like those of the simple players.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from hexwar_sb3.bots.config import drawn_hash
from hexwar_sb3.bots.registry import DRAWN_VERSION, FAMILIES
from hexwar_sb3.evaluation.acceptance import FIRST_GAMES, LEAST_USED, put_out
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action

REAL = 0.30  # win rate against "nearest" from which a member is a real opponent
LEAST_REAL = 0.25  # of the members of a family
LEAST_RANDOM = 0.95  # win rate of a family against random orders
PLANS = ("drawn-plan",)  # need not use every order


@dataclass(frozen=True, kw_only=True)
class AcceptDrawn:
    """Measure the drawn families against their bars; exit code 1 if one is missed."""

    members: int = 100  # of each family
    games: int = 50  # a member and colour
    seed: int = 0
    scenarios: tuple[str, ...] = STANDARD
    out: Path | None = None  # JSON file

    def run(self) -> int:
        """Play, then print or write the figures."""
        maps: dict[str, dict[str, Any]] = {
            name: {**provenance(name), **{family: self.accept(family, name) for family in FAMILIES}}
            for name in self.scenarios
        }
        failures = [
            f"{name}: {family} {failure}"
            for name, found in maps.items()
            for family in FAMILIES
            for failure in failures_of(family, found[family])
        ]
        head = {
            "members": self.members,
            "games": self.games,
            "seed": self.seed,
            "families": f"{DRAWN_VERSION} {drawn_hash()}",
        }
        text = json.dumps({**head, "failures": failures, "maps": maps}, indent=1) + "\n"
        put_out(text, self.out)
        return 1 if failures else 0

    def accept(self, family: str, scenario: str) -> dict[str, Any]:
        """Figures of a family on a map."""
        seed, terms = seed_for(Purpose.REPORT, self.seed), Terms(scenario=scenario)
        rates = []
        used = np.zeros(len(Action))
        for member in range(1, self.members + 1):
            red = play_games(f"{family}:{member}", "nearest", self.games, terms, seed)
            blue = play_games("nearest", f"{family}:{member}", self.games, terms, seed)
            rates.append(float((red.win.mean() + 1 - blue.win.mean()) / 2))
            used += (red.actions[:, 0] > 0).sum(axis=0) + (blue.actions[:, 1] > 0).sum(axis=0)
        n_games = 2 * self.games * self.members
        others = {
            opponent: play_games(family, opponent, self.games * 10, terms, seed)
            for opponent in ("random", "MA1", "MA2")
        }
        return {
            "against nearest": [round(rate, 4) for rate in rates],
            "real": float((np.array(rates) >= REAL).mean()),
            "as red against": {name: round(float(games.win.mean()), 4) for name, games in others.items()},
            "used": {action.name: round(float(used[action] / n_games), 4) for action in Action if action},
            "first_margins": others["MA1"].margin[:FIRST_GAMES].tolist(),
        }


def failures_of(family: str, found: dict[str, Any]) -> list[str]:
    """Say which bars a family misses."""
    missed = []
    if found["real"] < LEAST_REAL:
        missed.append(f"has {found['real']:.2f} members that win {REAL} against nearest")
    if found["as red against"]["random"] < LEAST_RANDOM:
        missed.append(f"wins {found['as red against']['random']:.3f} against random")
    return missed + [
        f"uses {action} in {share:.4f} of its games"
        for action, share in found["used"].items()
        if share < LEAST_USED and family not in PLANS
    ]


if __name__ == "__main__":
    sys.exit(tyro.cli(AcceptDrawn).run())
