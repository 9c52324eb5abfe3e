"""One group of a league: a red and a blue model train against each other and against others (Fig. 6 (b))."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.folders import making
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.judge import Judge, Rivals
from hexwar_sb3.league.member import CAMPS, Member
from hexwar_sb3.league.work import Opponents, Training, begin, env_steps, job_seed, one_thread

PAIRS = (CAMPS, CAMPS[::-1])  # who learns, and who is met


@dataclass(frozen=True, kw_only=True)
class GroupSpec(Training):
    """All that the training of a group depends on: in each part first red and then blue learns; leaves red/ and blue/."""

    members: Mapping[str, Member]  # by camp: who trains
    others: Mapping[str, Opponents]  # by camp: whom the model of that camp meets beside its partner
    partner_share: float  # of the games, against the partner as it is now
    games: int  # that a model learns from
    rounds: int  # parts of them; before the first and after each a version is judged
    anchor: float  # weight of staying near what entered
    refit_games: int  # before them, in which the mixer alone learns: it is new, and the replay is empty
    rivals: Mapping[str, Rivals]  # by camp: whom its versions are judged against
    trial: Terms  # of a version's games against each of them

    @property
    def steps(self) -> int:
        """Env steps of each of the two."""
        return env_steps(self.env, self.games)


def train_group(spec: GroupSpec) -> None:
    """Train both models (Fig. 6 (b)) and leave their folders: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: a member's folder is broken.
        TrainingError: a gradient is not finite; no folder is left.
    """
    if spec.folder.is_dir():
        return
    with making(spec.folder) as made, one_thread(), measured(made, "training"):
        for camp, judge in _train(spec).items():
            judge.save(made / camp)


def _train(spec: GroupSpec) -> dict[str, Judge]:
    """Let red and blue learn in turn; by camp, who knows the best version."""
    models = {}
    for camp in CAMPS:
        env = {**spec.env, "side": camp, "opponent": list(spec.others[camp]) or "MA1"}
        seed = job_seed(*spec.seed, CAMPS.index(camp))
        models[camp] = begin(spec.members[camp].policy(), env, spec.learner, seed, spec.anchor)
    judges = {camp: Judge(camp, spec.rivals[camp], spec.trial, spec.about) for camp in CAMPS}
    for camp, other in PAIRS:
        judges[camp].see(models[camp])
        _meet(models[camp], models[other], spec, camp)
        models[camp].refit_mixer(env_steps(spec.env, spec.refit_games))
    for part in range(spec.rounds):
        steps = spec.steps * (part + 1) // spec.rounds - spec.steps * part // spec.rounds
        for camp, other in PAIRS:
            _meet(models[camp], models[other], spec, camp)
            models[camp].learn(steps, reset_num_timesteps=False)
            judges[camp].see(models[camp])
    return judges


def _meet(model: QMIX, partner: QMIX, spec: GroupSpec, camp: str) -> None:
    """Let the model's next games be against its partner as it is now, and the others."""
    others = list(spec.others[camp])
    total = sum(weight for _, weight in others)
    shares = [(player, (1 - spec.partner_share) * weight / total) for player, weight in others]
    partner_share = spec.partner_share if shares else 1.0
    model.get_env().env_method("set_opponent", [(partner.policy.freeze(), partner_share), *shares])  # type: ignore[union-attr]
