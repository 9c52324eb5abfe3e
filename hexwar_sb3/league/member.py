"""A member of a league: a policy's folder of one colour."""

from __future__ import annotations

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


def as_member(model: QMIX, **about: str) -> FrozenPolicy:
    """What a model plays by."""
    return model.policy.freeze(rules=default_rules().hash, **about)
