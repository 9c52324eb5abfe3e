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
from hexwar_sb3.play.policy_files import PolicyFormat, Weights
from hexwar_sb3.rules.ruleset import default_rules

CAMPS = ("red", "blue")
MIXER_FOLDER = "mixer"  # in a member's folder
MIXER = PolicyFormat(
    "hexwar mixer",
    1,
    {  # Fig. 5
        "hyper_w1.0.weight": ("hidden", "state"),
        "hyper_w1.0.bias": ("hidden",),
        "hyper_w1.2.weight": ("weights", "hidden"),
        "hyper_w1.2.bias": ("weights",),
        "hyper_b1.weight": ("embed", "state"),
        "hyper_b1.bias": ("embed",),
        "hyper_w2.0.weight": ("hidden", "state"),
        "hyper_w2.0.bias": ("hidden",),
        "hyper_w2.2.weight": ("embed", "hidden"),
        "hyper_w2.2.bias": ("embed",),
        "hyper_b2.0.weight": ("embed", "state"),
        "hyper_b2.0.bias": ("embed",),
        "hyper_b2.2.weight": ("one", "embed"),
        "hyper_b2.2.bias": ("one",),
    },
)
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

    def mixer(self) -> Weights | None:
        """Read the mixer that its children go on with; None if it came without one.

        Raises:
            PolicyFileError: it is broken.
        """
        folder = self.folder / MIXER_FOLDER
        return MIXER.load(folder)[1] if folder.is_dir() else None

    def save_to(self, folder: Path) -> None:
        """Copy all that it takes to go on from it."""
        Version(self.policy(), self.mixer() or {}).save(folder)


@dataclass(frozen=True)
class Version:
    """What a model was at some moment: what it plays by, and what goes on learning."""

    policy: FrozenPolicy
    mixer: Weights  # none where the mixer has no weights

    def save(self, folder: Path) -> None:
        """Write both."""
        if self.mixer:
            MIXER.save(folder / MIXER_FOLDER, self.mixer, {}, {})
        self.policy.save(folder)


def as_member(model: QMIX, **about: str) -> FrozenPolicy:
    """What a model plays by."""
    return model.policy.freeze(rules=default_rules().hash, **about)


def settled(model: QMIX, **about: str) -> Version:
    """What a model is as the mean of its last updates."""
    policy = model.policy.freeze_settled(rules=default_rules().hash, **about)
    return Version(policy, model.policy.settled_mixer())


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
