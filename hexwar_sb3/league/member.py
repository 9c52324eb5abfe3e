"""A member of a league: a policy's folder of one colour."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.rules.ruleset import default_rules

CAMPS = ("red", "blue")


@dataclass(frozen=True, order=True)
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


def publish(made: Path, folder: Path) -> None:
    """Give a finished folder its name, at once or not at all; one of that name that is there stays."""
    try:
        os.replace(made, folder)  # noqa: PTH105  # as one step; pathlib says the same in other words
    except OSError:
        if not folder.is_dir():
            raise
        shutil.rmtree(made)
