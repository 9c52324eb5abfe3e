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


def save_member(model: QMIX, folder: Path, **about: str) -> None:
    """Write what a model plays by."""
    model.policy.freeze(rules=default_rules().hash, **about).save(folder)


@contextmanager
def making(folder: Path) -> Iterator[Path]:
    """Give a temporary folder that becomes `folder` when the block ends well: at once or not at all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(prefix=".new-", dir=folder.parent)) / folder.name
    made.mkdir()  # with the user's own mode; mkdtemp's shuts others out
    try:
        yield made
        _publish(made, folder)
    finally:
        shutil.rmtree(made.parent, ignore_errors=True)


def _publish(made: Path, folder: Path) -> None:
    """Give a finished folder its place; one that another process has put there stays."""
    try:
        made.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise
