"""The folder of a training run: what was asked, and where everything lies."""

from __future__ import annotations

import json
import warnings
from dataclasses import asdict, dataclass
from math import isnan
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.csv_file import number_in, read_rows
from hexwar_sb3.files import replacing
from hexwar_sb3.reading import read_json

ELAPSED = "time/time_elapsed"  # seconds since the start of a part, as Stable-Baselines3 logs them


@dataclass(frozen=True)
class RunFolder:
    """Paths of `runs/<name>_<k>/` (architecture.md, section 7)."""

    path: Path

    @classmethod
    def new(cls, runs: Path, name: str) -> RunFolder:
        """Make the first `runs/<name>_<k>` that is free."""
        runs.mkdir(parents=True, exist_ok=True)
        for k in range(1, 1_000_000):
            path = runs / f"{name}_{k}"
            try:
                path.mkdir()
            except FileExistsError:
                continue
            return cls(path)
        raise FileExistsError(f"{runs} is full of runs named {name}")

    @property
    def config(self) -> Path:
        """What was asked, as JSON."""
        return self.path / "config.json"

    @property
    def preset(self) -> Path:
        """Copy of the preset's file, where one was given."""
        return self.path / "preset.json"

    @property
    def model(self) -> Path:
        """The model at the end, as Stable-Baselines3 saves it."""
        return self.path / "model.zip"

    @property
    def policy(self) -> Path:
        """The policy alone: what opponents, viewers and others load."""
        return self.path / "policy"

    @property
    def untrained(self) -> Path:
        """The policy before training, for the page at the end."""
        return self.path / "untrained"

    @property
    def checkpoint(self) -> Path:
        """All that a resumed run needs."""
        return self.path / "checkpoint.npz"

    @property
    def pool(self) -> Path:
        """Copies of the commander as it was, which it met in training."""
        return self.path / "pool"

    @property
    def snapshots(self) -> Path:
        """What played in each evaluation, by env steps."""
        return self.path / "snapshots"

    @property
    def replays(self) -> Path:
        """Recorded games."""
        return self.path / "replays"

    @property
    def album(self) -> Path:
        """How the commander changed, as a page of its games."""
        return self.path / "album.html"

    @property
    def page(self) -> Path:
        """What was learned, as text; its figures lie beside it as JSON."""
        return self.path / "page.txt"

    def minutes_before(self) -> float:
        """Wall time of the earlier parts of a run that was broken off, by their logs.

        A kill may leave a broken log. Its time is lost, the run is not: a warning, and it counts as nothing.
        """
        return sum(_seconds(part) for part in self.path.glob("progress_*.csv")) / 60

    def write_config(self, config: Any, command: str) -> None:
        """Write the settings (a dataclass) and the command line."""
        write_text(self.config, json.dumps(asdict(config), indent=2, default=str) + "\n")
        write_text(self.path / "command.txt", command + "\n")

    def read_config(self) -> dict[str, Any]:
        """Read the settings of a run.

        Raises:
            FileFormatError: there are none, or they are no JSON object.
        """
        return read_json(self.config, "a run's settings")


def _seconds(log: Path) -> float:
    try:
        # Before its first games end, a part has no times.
        found = [number_in(row, ELAPSED, log) for row in read_rows(log) if ELAPSED in row]
    except FileFormatError as error:
        warnings.warn(f"{error}; the time it tells of is not counted", stacklevel=3)
        return 0.0
    return max((seconds for seconds in found if not isnan(seconds)), default=0.0)


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")  # of names that are no UTF-8
