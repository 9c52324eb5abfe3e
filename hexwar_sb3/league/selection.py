"""Who is kept: weighted win rate in a single round robin of all red against all blue models, and their rivals."""

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
    rivals: Sequence[str] = (),
    jobs: int = 1,
) -> Table:
    """Play every red model against every blue one, and all of them against the rivals.

    Args:
        reds: players by name.
        blues: likewise; a name may be in both.
        evaluation: how they are played.
        folder: gets a file a match.
        rivals: further players of both colours, by name, who do not meet each other.
        jobs: matches side by side.
    """
    pairs = [(red, blue) for red in (*reds, *rivals) for blue in (*blues, *rivals)]
    meetings = [
        Meeting(red=red, blue=blue, scenario=str(evaluation.terms.scenario))
        for red, blue in pairs
        if red in reds or blue in blues
    ]
    players = {name: name for name in rivals}
    return play_meetings(meetings, {**reds, **players}, {**blues, **players}, evaluation, folder, jobs=jobs)


def weights(rates: Sequence[float], are_rivals: Sequence[bool], rivals_share: float) -> list[float]:
    """Weights of a model's win rates: of the rivals only the one that it does worst against counts.

    What a model has forgotten of one rival it cannot make up for with the others.

    Args:
        rates: against each opponent.
        are_rivals: which of the opponents are rivals, and no models of the league.
        rivals_share: weight of that rival; the rest is shared by the models.

    Returns:
        A weight for each opponent; they add up to 1.
    """
    worst = min(
        (k for k, is_rival in enumerate(are_rivals) if is_rival), key=lambda k: rates[k], default=None
    )
    share = (1.0 - rivals_share) / max(1, len(rates) - sum(are_rivals))
    found = [0.0 if is_rival else share for is_rival in are_rivals]
    if worst is not None:
        found[worst] = rivals_share
    return [weight / sum(found) for weight in found]


def standings(
    table: Table, camp: str, rivals: Sequence[str] = (), rivals_share: float = 0.0
) -> list[Standing]:
    """Models of a colour by their weighted win rate, the best first; equal ones by margin, then by name.

    Args:
        table: of the round robin.
        camp: "red" or "blue".
        rivals: players of it that are no models.
        rivals_share: weight of the one that a model does worst against.

    Returns:
        Rows with the weighted win rate in 0..1, its Wilson interval for as many games of equal weight, and the margin
        with the same weights, in points. The interval leaves out that the worst rival was picked by these games.
    """
    enemy = "blue" if camp == "red" else "red"
    rows: dict[str, list[tuple[bool, Mapping[str, Any]]]] = {}
    for meeting, row in table.rows.items():
        if getattr(meeting, camp) not in rivals:
            is_rival = getattr(meeting, enemy) in rivals
            rows.setdefault(getattr(meeting, camp), []).append((is_rival, row[camp]))
    found = []
    for name, results in rows.items():
        are_rivals, cells = zip(*results, strict=True)
        shares = weights([cell["win_rate"] for cell in cells], are_rivals, rivals_share)
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
        >>> red = [{"name": name, "win_rate": rate, "mean_margin": 0.0} for name, rate in [("a", 0.4), ("b", 0.6)]]
        >>> select({"red": red, "blue": red}, keep=4, split=True)["red"]
        ['b', 'a', 'b', 'a']
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
