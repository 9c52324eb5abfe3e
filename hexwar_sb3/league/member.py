"""A member of a league: a policy's folder of one colour."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.rules.ruleset import default_rules

CAMPS = ("red", "blue")
UNFINISHED = ".new-"  # begins the names of folders that are being made


@dataclass(frozen=True)
class Member:
    """A policy of one colour in the league's folder."""

    camp: str
    name: str
    folder: Path

    def policy(self) -> FrozenPolicy:
        """Read it.

        Raises:
            PolicyFileError: it is broken, or plays by other rules.
        """
        return FrozenPolicy.load(self.folder, rules=default_rules().hash)


def as_member(model: QMIX, **about: str) -> FrozenPolicy:
    """What a model plays by."""
    return model.policy.freeze(rules=default_rules().hash, **about)


@contextmanager
def making(folder: Path) -> Iterator[Path]:
    """Give a temporary folder that becomes `folder` when the block ends well: at once or not at all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(prefix=UNFINISHED, dir=folder.parent)) / folder.name
    made.mkdir()  # with the user's own mode; mkdtemp's shuts others out
    try:
        yield made
        _publish(made, folder)
    finally:
        shutil.rmtree(made.parent, ignore_errors=True)


def clear_unfinished(folder: Path) -> None:
    """Remove what processes that were killed were making there."""
    for left in folder.glob(f"{UNFINISHED}*"):
        shutil.rmtree(left, ignore_errors=True)


def _publish(made: Path, folder: Path) -> None:
    """Give a finished folder its place; one that another process has put there stays."""
    try:
        made.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise
