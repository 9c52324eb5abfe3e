"""The best version of a model: as it learns, its versions play against a fixed panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.league.selection import weights
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.rules.ruleset import default_rules


@dataclass(frozen=True)
class Rivals:
    """Whom versions of a model are judged against, players of the other camp."""

    models: Sequence[object]
    bots: Sequence[str]
    bots_share: float  # weight of the bot that a version does worst against


@dataclass
class Judge:
    """Lets versions of a model play, and remembers the one that wins most."""

    camp: str  # of the model
    rivals: Rivals
    terms: Terms  # of the games against each of them
    about: Mapping[str, str]  # texts for the policies
    best: FrozenPolicy | None = None
    score: float = -1.0  # of the best: weighted win rate, as in the round robin, 0..1

    def see(self, model: QMIX) -> None:
        """Let what the model is now play, as the mean of its last updates."""
        version = model.policy.freeze_settled(rules=default_rules().hash, side=self.camp, **self.about)
        met = {False: self.rivals.models, True: self.rivals.bots}
        players = [(other, is_bot) for is_bot, others in met.items() for other in others]
        rates = [self.terms.play_as(self.camp, version, other).win_rate.value for other, _ in players]
        shares = weights(rates, [is_bot for _, is_bot in players], self.rivals.bots_share)
        score = float(np.dot(shares, rates))
        if score > self.score:
            self.best, self.score = version, score

    def save(self, folder: Path) -> None:
        """Write the best version."""
        cast("FrozenPolicy", self.best).save(folder)
