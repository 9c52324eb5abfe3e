"""Who is kept: weighted win rate in a single round robin of all red against all blue models, and the bots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.tournament import Meeting, Table, play_meetings
from hexwar_sb3.league.member import CAMPS

Standing = dict[str, Any]  # name, win_rate with its interval, mean_margin


def play_all(
    reds: Mapping[str, object],
    blues: Mapping[str, object],
    evaluation: Evaluation,
    folder: Path,
    *,
    bots: Sequence[str] = (),
    jobs: int = 1,
) -> Table:
    """Play every red model against every blue one, and all of them against the bots.

    Args:
        reds: players by name.
        blues: likewise; a name may be in both.
        evaluation: how they are played.
        folder: gets a file a match.
        bots: further players of both colours, who do not meet each other.
        jobs: matches side by side.
    """
    pairs = [(red, blue) for red in (*reds, *bots) for blue in (*blues, *bots)]
    meetings = [
        Meeting(red=red, blue=blue, scenario=str(evaluation.terms.scenario))
        for red, blue in pairs
        if red in reds or blue in blues
    ]
    players = {bot: bot for bot in bots}
    return play_meetings(meetings, {**reds, **players}, {**blues, **players}, evaluation, folder, jobs=jobs)


def weights(rates: Sequence[float], are_bots: Sequence[bool], bots_share: float) -> list[float]:
    """Weights of a model's win rates: of the bots only the one that it does worst against counts.

    What a model has forgotten of one bot it cannot make up for with the others.

    Args:
        rates: against each opponent.
        are_bots: which of the opponents are bots.
        bots_share: weight of that bot; the rest is shared by the others that are no bots.

    Returns:
        A weight for each opponent; they add up to 1.
    """
    worst = min((k for k, is_bot in enumerate(are_bots) if is_bot), key=lambda k: rates[k], default=None)
    share = (1.0 - bots_share) / max(1, len(rates) - sum(are_bots))
    found = [0.0 if is_bot else share for is_bot in are_bots]
    if worst is not None:
        found[worst] = bots_share
    return [weight / sum(found) for weight in found]


def standings(table: Table, camp: str, bots: Sequence[str] = (), bots_share: float = 0.0) -> list[Standing]:
    """Models of a colour by their weighted win rate, the best first; equal ones by margin, then by name.

    Args:
        table: of the round robin.
        camp: "red" or "blue".
        bots: players of it that are no models.
        bots_share: weight of the bot that a model does worst against.

    Returns:
        Rows with the weighted win rate in 0..1, its Wilson interval for as many games of equal weight, and the margin
        with the same weights, in points. The interval leaves out that the worst bot was picked by these games, and that
        a league's judges saw some of those against bots.
    """
    enemy = "blue" if camp == "red" else "red"
    rows: dict[str, list[tuple[bool, Mapping[str, Any]]]] = {}
    for meeting, row in table.rows.items():
        if getattr(meeting, camp) not in bots:
            is_bot = getattr(meeting, enemy) in bots
            rows.setdefault(getattr(meeting, camp), []).append((is_bot, row[camp]))
    found = []
    for name, results in rows.items():
        are_bots, cells = zip(*results, strict=True)
        shares = weights([cell["win_rate"] for cell in cells], are_bots, bots_share)
        weighted = list(zip(shares, cells, strict=True))
        rate, margin = (
            sum(share * cell[key] for share, cell in weighted) for key in ("win_rate", "mean_margin")
        )
        games = 1.0 / sum(share**2 / cell["games"] for share, cell in weighted)  # as many equal ones
        interval = wilson(rate * games, games)
        found.append(
            {
                "name": name,
                "win_rate": rate,
                "win_rate_interval": [interval.low, interval.high],
                "mean_margin": margin,
            }
        )
    return sorted(found, key=lambda one: (-one["win_rate"], -one["mean_margin"], one["name"]))


def select(rows: Mapping[str, Sequence[Standing]], keep: int, *, split: bool) -> dict[str, list[str]]:
    """Names of the best models by colour, the best first; repeated where there are fewer.

    Args:
        rows: standings by colour.
        keep: how many.
        split: each colour has models of its own; else the mean of both colours counts.

    Example:
        >>> select(rows, keep=4, split=True)["red"]
        ['3-r0b2', '3-r1b2', '3-r0b0', '3-r3b2']
    """
    kept: dict[str, list[str]] = {}
    for camp in CAMPS:
        of = rows if not split else {camp: rows[camp]}
        scores: dict[str, list[tuple[float, float]]] = {}
        for row in (row for standing in of.values() for row in standing):
            scores.setdefault(row["name"], []).append((row["win_rate"], row["mean_margin"]))
        means = {name: tuple(np.mean(found, axis=0)) for name, found in scores.items()}
        names = sorted(means, key=lambda name: (*(-value for value in means[name]), name))
        kept[camp] = [names[k % len(names)] for k in range(keep)]
    return kept
