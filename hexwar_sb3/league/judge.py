"""The best version of a model: as it learns, its versions play against a fixed panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.rules.ruleset import default_rules


@dataclass
class Judge:
    """Lets versions of a model play, and remembers the one that wins most."""

    camp: str  # of the model
    panel: Sequence[object]  # players of the other camp
    terms: Terms  # of the games against each of them
    about: Mapping[str, str]  # texts for the policies
    best: FrozenPolicy | None = None
    win_rate: float = -1.0  # of the best, over all its games, 0..1

    def see(self, model: QMIX) -> None:
        """Let what the model is now play, as the mean of its last updates."""
        version = model.policy.freeze_settled(rules=default_rules().hash, side=self.camp, **self.about)
        win_rate = CampResult.joined(self._play(version, other) for other in self.panel).win_rate.value
        if win_rate > self.win_rate:
            self.best, self.win_rate = version, win_rate

    def _play(self, version: FrozenPolicy, other: object) -> CampResult:
        if self.camp == "red":
            return self.terms.play(version, other).red
        return self.terms.play(other, version).blue

    def save(self, folder: Path) -> None:
        """Write the best version."""
        cast("FrozenPolicy", self.best).save(folder)
