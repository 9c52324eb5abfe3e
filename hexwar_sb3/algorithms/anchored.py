"""QMIX that stays near the policy that it goes on from."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar

import torch
from jaxtyping import Float
from torch import Tensor

from hexwar_sb3.algorithms.distillation import masked_kl
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.ranges import NOT_NEGATIVE, POSITIVE, Table
from hexwar_sb3.algorithms.replay import Batch
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.policies.agent import TaskNetwork


class AnchoredQMIX(QMIX):
    """QMIX with a second loss: how far its choices are from those of the policy that it took over.

    What was distilled has the teachers' choices but not the values of what follows; temporal differences alone undo
    it within a few hundred games. Self-play from a taught policy is held in the same way by Schmitt et al. (2018,
    "Kickstarting") and Vinyals et al. (2019).

    Args:
        args: as `QMIX`.
        anchor_weight: of the masked KL from the policy taken over, beside the loss of the targets; a model that was
            saved and loaded has no anchor until it takes over a policy again.
        anchor_tau: temperature of choices in it, in scaled points.
        kwargs: further arguments of `QMIX`.
    """

    zip_name: ClassVar[str] = "AnchoredQMIX"
    settings: ClassVar[Table] = {**QMIX.settings, "anchor_weight": NOT_NEGATIVE, "anchor_tau": POSITIVE}

    anchor: TaskNetwork | None = None

    def __init__(
        self, *args: Any, anchor_weight: float = 0.1, anchor_tau: float = 0.1, **kwargs: Any
    ) -> None:
        self.anchor_weight, self.anchor_tau = anchor_weight, anchor_tau
        super().__init__(*args, **kwargs)

    def take_over(self, policy: FrozenPolicy) -> None:
        """Go on from a frozen policy, and stay near it."""
        super().take_over(policy)
        self.anchor = deepcopy(self.policy.agent).requires_grad_(False)

    def further_loss(self, batch: Batch) -> Float[Tensor, ""] | float:
        """Weighted KL from the policy taken over; 0 where there is none."""
        if self.anchor is None or self.anchor_weight == 0.0:
            return 0.0
        sets = batch.now.sets
        with torch.no_grad():
            wanted = self.anchor.q_values(sets)
        given = self.policy.agent.q_values(sets)
        return self.anchor_weight * masked_kl(given, wanted, sets, batch.now.alive.flatten(), self.anchor_tau)
