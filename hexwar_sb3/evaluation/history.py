"""The evaluations of a training run: what was reached after how many steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.panel import Panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.files import replacing
from hexwar_sb3.reading import opened, read_arrays

Arrays = dict[str, NDArray[Any]]
KEYS = ("timesteps", "game_ticks", "results", "successes", "points_held")


@dataclass
class History:
    """Evaluations in the order in which they were made; the same number of games each time.

    The file has the keys of Stable-Baselines3's `evaluations.npz`: `timesteps` [evaluation],
    `results` (margins) and `successes` (1, 0.5, 0) [evaluation, game]; and `points_held`, and `game_ticks`, the game
    time of all levels until then.
    """

    timesteps: list[int] = field(default_factory=list)
    game_ticks: list[int] = field(default_factory=list)
    results: list[CampResult] = field(default_factory=list)

    def add(self, timesteps: int, game_ticks: int, panel: Panel) -> CampResult:
        """Append the games of a panel and return them, joined."""
        self.timesteps.append(timesteps)
        self.game_ticks.append(game_ticks)
        self.results.append(panel.total)
        return panel.total

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all."""
        with replacing(path) as temporary:
            np.savez_compressed(
                temporary,
                timesteps=np.array(self.timesteps),
                game_ticks=np.array(self.game_ticks),
                results=np.array([result.margins for result in self.results]),
                successes=np.array([result.scores for result in self.results]),
                points_held=np.array([result.points_held for result in self.results]),
            )

    @classmethod
    def load(cls, path: Path, until: int | None = None) -> History:
        """Read the file; `until` leaves out what was evaluated after that many steps.

        Raises:
            FileFormatError: the file is not one of ours.
        """
        expected = f"arrays {KEYS}"
        with opened(path, expected=expected) as file:
            data = read_arrays(file, path, expected=expected)
        if problem := _problem(data):
            raise FileFormatError(path, "file", found=problem, expected=expected)
        timesteps, ticks, margins, scores, points = (data[key] for key in KEYS)
        rows = [i for i, step in enumerate(timesteps) if until is None or step <= until]
        return cls(
            [int(timesteps[i]) for i in rows],
            [int(ticks[i]) for i in rows],
            [CampResult(scores[i], margins[i], points[i]) for i in rows],
        )


def _problem(data: Arrays) -> str | None:
    """What is wrong with the arrays of a file; None: nothing."""
    if missing := [key for key in KEYS if key not in data]:
        return f"no {missing[0]!r}"
    timesteps, ticks, margins, scores, points = (data[key] for key in KEYS)
    for key in KEYS:
        if data[key].dtype.kind not in "iuf" or not np.isfinite(data[key]).all():
            return f"values in {key!r} that are no finite numbers"
    if timesteps.ndim != 1 or ticks.shape != timesteps.shape or (np.diff(timesteps) < 0).any():
        return f"timesteps {timesteps.shape} and game_ticks {ticks.shape}"
    games = margins.shape[:1] == timesteps.shape and (margins.ndim == 2 or not timesteps.size)
    if not games or scores.shape != margins.shape or points.shape != margins.shape:
        return f"results {margins.shape}, successes {scores.shape} and points_held {points.shape}"
    if not np.isin(scores, (0.0, 0.5, 1.0)).all():
        return "a success that is none of 0, 0.5 and 1"
    if min(array.min(initial=0) for array in (timesteps, ticks, points)) < 0:
        return "a number below 0"
    return None
