"""One group of a league: models train against partners and against others (Fig. 6 (b))."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hexwar_sb3.folders import making
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.member import BOTH, CAMPS, Member, leave
from hexwar_sb3.league.work import Opponents, Training, begin, go_on, job_seed, one_thread

PAIRS = (CAMPS, CAMPS[::-1])  # who learns, and who is met


@dataclass(frozen=True, kw_only=True)
class GroupSpec(Training):
    """All that the training of a group depends on; leaves the model of each camp, or of both.

    In a league of models for both camps the red member learns, and all that were kept are its partners.
    """

    members: Mapping[str, Member]  # by camp: who trains
    partners: Sequence[Member]  # of a model for both camps; one of a single camp has the other member
    others: Mapping[str, Opponents]  # by camp: whom the model of that camp meets beside its partner
    partner_share: float  # of the weights, for the partners
    split: bool  # each camp has a model of its own


def train_group(spec: GroupSpec) -> None:
    """Train and leave folders (Fig. 6 (b)): a function of `spec` alone, in any process.

    Red learns against blue as it came, then blue against red as it is now.

    Raises:
        PolicyFileError: a member's folder is broken.
        CheckpointError: the model in it is.
        TrainingError: a gradient is not finite; no folder is left.
    """
    if spec.folder.is_dir():
        return
    with making(spec.folder) as made, one_thread(), measured(made, "training"):
        members = dict(spec.members)
        for camp, other in PAIRS if spec.split else PAIRS[:1]:
            side = camp if spec.split else BOTH
            partners = [members[other]] if spec.split else spec.partners
            opponents = with_partners(partners, spec.partner_share, spec.others[camp])
            env = {**spec.env, "side": side, "opponent": opponents}
            model = begin(members[camp], env, spec.learner, job_seed(*spec.seed, CAMPS.index(camp)))
            go_on(model, spec)
            leave(model, made / side, side=side, **spec.about)
            members[camp] = Member(camp, members[camp].name, made / side)


def with_partners(
    partners: Sequence[Member], share: float, others: Opponents
) -> Sequence[tuple[object, float]]:
    """Opponents with their weights: the partners, which have a share together, and the others."""
    total = sum(weight for _, weight in others)
    rest = [(player, (1.0 - share) * weight / total) for player, weight in others]
    each = (share if rest else 1.0) / len(partners)
    return [*((partner.policy(), each) for partner in partners), *rest]
