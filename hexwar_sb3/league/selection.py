"""Who is kept: by a single round robin of all red against all blue models, and their rivals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.tournament import Meeting, Table, play_meetings
from hexwar_sb3.league.member import CAMPS

Standing = dict[str, Any]  # name, score, win_rate with its interval, behind, mean_margin


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


def standings(
    table: Table, camp: str, rivals: Sequence[str] = (), worst_share: float = 0.0
) -> list[Standing]:
    """Models of a colour by their score, the best first; equal ones by margin, then by name.

    The score is the mean win rate against models, and for `worst_share` of it 1 less what the model is behind: by
    how much another model of this colour does better against some rival, at most. So none can make up with the other
    opponents for what it forgot of one, and one that is hard for all decides nothing.

    Args:
        table: of the round robin.
        camp: "red" or "blue".
        rivals: players of it that are no models; without a share they count as models do.
        worst_share: of the score, for the rival against which a model is most behind.

    Returns:
        Rows; win rates and their Wilson intervals are against models, margins (points) against everybody.
    """
    enemy, cells = "blue" if camp == "red" else "red", dict[str, dict[str, Mapping[str, Any]]]()
    for meeting, row in table.rows.items():
        if getattr(meeting, camp) not in rivals:
            cells.setdefault(getattr(meeting, camp), {})[getattr(meeting, enemy)] = row[camp]
    apart = [rival for rival in rivals if worst_share > 0.0 and any(rival in own for own in cells.values())]
    best = {rival: max(own[rival]["win_rate"] for own in cells.values()) for rival in apart}
    found = [_standing(name, own, best, worst_share) for name, own in cells.items()]
    return sorted(found, key=lambda one: (-one["score"], -one["mean_margin"], one["name"]))


def _standing(
    name: str, cells: Mapping[str, Mapping[str, Any]], best: Mapping[str, float], worst_share: float
) -> Standing:
    """Row of a model, by its cells against each opponent and the best win rates against rivals."""
    met = [cell for opponent, cell in cells.items() if opponent not in best]
    rate, games = fmean(cell["win_rate"] for cell in met), sum(cell["games"] for cell in met)
    behind = max((most - cells[rival]["win_rate"] for rival, most in best.items()), default=0.0)
    share, interval = worst_share if best else 0.0, wilson(rate * games, games)
    return {
        "name": name,
        "score": (1.0 - share) * rate + share * (1.0 - behind),
        "win_rate": rate,
        "win_rate_interval": [interval.low, interval.high],
        "behind": behind,
        "mean_margin": fmean(cell["mean_margin"] for cell in cells.values()),
    }


def select(rows: Mapping[str, Sequence[Standing]], keep: int, *, split: bool) -> dict[str, list[str]]:
    """Names of the best models by colour, the best first; repeated where there are fewer.

    Args:
        rows: standings by colour.
        keep: how many.
        split: each colour has models of its own; else the mean of both colours counts.

    Example:
        >>> red = [{"name": name, "score": rate, "mean_margin": 0.0} for name, rate in [("a", 0.4), ("b", 0.6)]]
        >>> select({"red": red, "blue": red}, keep=4, split=True)["red"]
        ['b', 'a', 'b', 'a']
    """
    kept: dict[str, list[str]] = {}
    for camp in CAMPS:
        of = rows if not split else {camp: rows[camp]}
        scores: dict[str, list[tuple[float, float]]] = {}
        for row in (row for standing in of.values() for row in standing):
            scores.setdefault(row["name"], []).append((row["score"], row["mean_margin"]))
        means = {name: tuple(np.mean(found, axis=0)) for name, found in scores.items()}
        names = sorted(means, key=lambda name: (*(-value for value in means[name]), name))
        kept[camp] = [names[k % len(names)] for k in range(keep)]
    return kept
