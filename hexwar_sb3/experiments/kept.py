"""What is kept of the runs of an experiment, small enough to be committed.

`runs.json` has a line a run: its command, its settings, its page. `curves.csv` has the learning curves of all, and
`policies/` a folder for each run whose policy is kept.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.experiments.curve import read_curve, write_curve
from hexwar_sb3.files import write_entries
from hexwar_sb3.folders import making
from hexwar_sb3.kinds import fits, read_fields
from hexwar_sb3.reading import read_json

RUNS, CURVES, POLICIES = "runs.json", "curves.csv", "policies"


@dataclass(frozen=True, kw_only=True)
class Record:
    """The line of a run."""

    command: str  # that makes it again
    config: dict[str, Any]  # its settings
    page: dict[str, Any]  # its figures


@dataclass(frozen=True, kw_only=True)
class PageRow:
    """What an experiment reads of a row of a page: a player against an opponent in a camp."""

    player: str
    opponent: str
    camp: str
    win_rate: float
    mean_margin: float
    points_held: tuple[float, ...]  # shares of the games with 0, 1, 2, ... of them

    @property
    def mean_points(self) -> float:
        """Control points held, on average."""
        return sum(k * share for k, share in enumerate(self.points_held))


@dataclass(frozen=True)
class Kept:
    """The results of a run, there or not."""

    folder: Path  # of its experiment
    name: str  # of the run

    @property
    def policy(self) -> Path:
        """Folder of its policy."""
        return self.folder / POLICIES / self.name

    @property
    def is_there(self) -> bool:
        """The run was kept.

        Raises:
            FileFormatError: the file of the runs is broken.
        """
        return self.name in read_runs(self.folder)

    @property
    def command(self) -> str:
        """Command line that made it.

        Raises:
            FileFormatError: it is not there, or the file is broken.
        """
        return self._record.command

    @property
    def minutes(self) -> float:
        """Minutes that the training took.

        Raises:
            FileFormatError: the run is not there, or its page is broken.
        """
        return self._minutes("minutes")

    @property
    def core_minutes(self) -> float:
        """Processor time of the training, in minutes; its wall time where the page is of a version that did not count it.

        Raises:
            FileFormatError: the run is not there, or its page is broken.
        """
        return self._minutes("core_minutes" if "core_minutes" in self._record.page else "minutes")

    def rows(self, *, others: bool = False) -> list[PageRow]:
        """Rows of its page.

        Args:
            others: with those of the trained player against others than it was to be measured by, if it has any.

        Raises:
            FileFormatError: the run is not there, or its page is broken.
        """
        found: list[PageRow] = []
        page = self._record.page
        for part in ("rows", "others") if others and "others" in page else ("rows",):
            rows = page.get(part)
            if not isinstance(rows, list):
                raise self._error(f"page.{part}", repr(rows), "a list of rows")
            found += [self._row(f"page.{part}[{n}]", row) for n, row in enumerate(rows)]
        return found

    def curve(self, opponent: str) -> dict[str, list[float]]:
        """Columns of its learning curve against one opponent.

        Raises:
            FileFormatError: the table is broken, or has no row of this run and opponent.
        """
        return read_curve(self.folder / CURVES, self.name, opponent)

    def put(self, record: Record, curve: Iterable[dict[str, Any]], policy: Path | None = None) -> None:
        """Keep a run: the line in `runs.json` comes last, and says that all is there.

        Args:
            record: its line.
            curve: rows of its learning curve.
            policy: folder that is copied; None keeps none.
        """
        rows = list(curve)  # first of all: what it is made from may be broken
        if policy is not None:
            shutil.rmtree(self.policy, ignore_errors=True)
            with making(self.policy) as made:
                shutil.copytree(policy, made, dirs_exist_ok=True)
        write_curve(self.folder / CURVES, self.name, rows)
        runs = {**read_runs(self.folder), self.name: record}
        write_entries(self.folder / RUNS, {name: asdict(one) for name, one in runs.items()})

    @property
    def _record(self) -> Record:
        runs = read_runs(self.folder)
        if self.name not in runs:
            raise FileFormatError(self.folder / RUNS, "runs", found="none of this name", expected=self.name)
        return runs[self.name]

    def _minutes(self, name: str) -> float:
        found = self._record.page.get(name)
        if not isinstance(found, float | int) or not fits(found, float) or found < 0:
            raise self._error(f"page.{name}", repr(found), "a number of at least 0")
        return float(found)

    def _row(self, place: str, row: object) -> PageRow:
        names = PageRow.__dataclass_fields__
        own = {name: one for name, one in row.items() if name in names} if isinstance(row, dict) else row
        where = f"{self.name}.{place}"
        return PageRow(**read_fields(PageRow, own, self.folder / RUNS, place=where, whole=True))

    def _error(self, place: str, found: str, expected: str) -> FileFormatError:
        return FileFormatError(self.folder / RUNS, f"{self.name}.{place}", found=found, expected=expected)


def read_runs(folder: Path) -> dict[str, Record]:
    """Records of the runs that are kept in a folder, by name.

    Raises:
        FileFormatError: the file is broken.
    """
    path = folder / RUNS
    if not path.is_file():
        return {}
    at = path.stat()
    return _read_runs(path, at.st_mtime_ns, at.st_size, at.st_ino)


@lru_cache(maxsize=16)
def _read_runs(path: Path, *_: int) -> dict[str, Record]:
    """Read a file that has not changed once only."""
    runs = read_json(path, "runs").items()
    return {
        name: Record(**read_fields(Record, record, path, place=name, whole=True)) for name, record in runs
    }
