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
from hexwar_sb3.maps.scenario import MAX_CONTROL_POINTS
from hexwar_sb3.reading import read_arrays, read_bytes

MAX_BYTES = 1 << 24
MOST = 2**53  # of steps and ticks
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
        arrays = read_arrays(read_bytes(path, MAX_BYTES), path)
        _check(arrays, path)
        timesteps, ticks, margins, scores, points = (arrays[key] for key in KEYS)
        rows = [i for i, step in enumerate(timesteps) if until is None or step <= until]
        return cls(
            [int(timesteps[i]) for i in rows],
            [int(ticks[i]) for i in rows],
            [CampResult(scores[i], margins[i], points[i]) for i in rows],
        )


def _check(arrays: dict[str, NDArray[Any]], path: Path) -> None:
    """Check shapes, kinds and ranges: a row an evaluation, a column a game."""
    if set(arrays) != set(KEYS):
        raise FileFormatError(path, "file", found=f"arrays {tuple(arrays)}", expected=f"arrays {KEYS}")
    if not any(array.size for array in arrays.values()):
        return  # a run without an evaluation
    rows, games = arrays["timesteps"].shape[:1], arrays["results"].shape[1:]
    for name, array in arrays.items():
        is_count = name in KEYS[:2]
        shape = rows if is_count else (*rows, *games)
        kinds = "iu" if is_count or name == "points_held" else "fiu"
        if array.shape != shape or len(shape) != 2 - is_count or array.dtype.kind not in kinds:
            found, expected = (
                f"{array.dtype} {array.shape}",
                f"numbers [evaluation{', game' * (not is_count)}]",
            )
            raise FileFormatError(path, name, found=found, expected=expected)
        most = {"successes": 1, "points_held": MAX_CONTROL_POINTS}.get(name, MOST)
        least = -MOST if name == "results" else 0
        if array.size and not (least <= array.min() and array.max() <= most):  # a NaN is neither
            raise FileFormatError(path, name, found="a number out of range", expected=f"{least}..{most}")
        if is_count and (array[1:] < array[:-1]).any():
            raise FileFormatError(
                path, name, found="numbers that fall", expected="one evaluation after another"
            )
