"""One group of a league: a red and a blue model train against each other and against others (Fig. 6 (b))."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.judge import Judge
from hexwar_sb3.league.member import CAMPS, Member, making
from hexwar_sb3.league.school import Class, School, attend
from hexwar_sb3.league.work import Opponents, env_steps, job_seed, one_thread

PAIRS = (CAMPS, CAMPS[::-1])  # who learns, and who is met


@dataclass(frozen=True, kw_only=True)
class GroupSpec:
    """All that the training of a group depends on: in each part first red and then blue learns; leaves red/ and blue/."""

    members: Mapping[str, Member]  # by camp: who trains
    others: Mapping[str, Opponents]  # by camp: whom the model of that camp meets beside its partner
    partner_share: float  # of the games, against the partner as it is now
    school: School  # that they go to first
    classes: Mapping[str, Sequence[Class]]  # by camp: of that school
    games: int  # that a model then learns from by itself
    rounds: int  # parts of them; after each a version is judged
    refit_games: int  # before them, in which the mixer alone learns: it is new, and the replay is empty
    panels: Mapping[str, Sequence[object]]  # by camp: whom its versions are judged against
    trial: Terms  # of a version's games against each of its panel
    seed: tuple[int, ...]  # numbers that name the training
    folder: Path  # gets the policies
    env: Mapping[str, Any]  # settings of the task env
    learner: Mapping[str, Any]  # arguments of QMIX
    about: Mapping[str, str]  # texts for the policies' folders

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
    """Let red and blue go to school, then learn in turn; by camp, who knows the best version."""
    models = {camp: _start(spec, camp) for camp in CAMPS}
    judges = {camp: Judge(camp, spec.panels[camp], spec.trial, spec.about) for camp in CAMPS}
    for camp, model in models.items():
        if spec.classes[camp]:
            seed = job_seed(*spec.seed, len(CAMPS) + CAMPS.index(camp))
            attend(model, spec.classes[camp], {**spec.env, "side": camp}, spec.school, seed)
            judges[camp].see(model)
    for camp, other in PAIRS:
        _meet(models[camp], models[other], spec, camp)
        models[camp].refit_mixer(env_steps(spec.env, spec.refit_games))
    for part in range(spec.rounds):
        steps = spec.steps * (part + 1) // spec.rounds - spec.steps * part // spec.rounds
        for camp, other in PAIRS:
            _meet(models[camp], models[other], spec, camp)
            models[camp].learn(steps, reset_num_timesteps=False)
            judges[camp].see(models[camp])
    return judges


def _start(spec: GroupSpec, camp: str) -> QMIX:
    """Make the learner of a camp, where its member left off."""
    member, seed = spec.members[camp], job_seed(*spec.seed, CAMPS.index(camp))
    policy = member.policy()
    env = make_vec_env(
        "HexWarTask-v0",
        seed=seed_for(Purpose.TRAINING, seed),
        side=camp,
        opponent=list(spec.others[camp]) or "MA1",
        lower=policy.lower,
        **spec.env,
    )
    model = QMIX("TaskPolicy", env, seed=seed, **spec.learner)
    model.take_over(policy)
    return model


def _meet(model: QMIX, partner: QMIX, spec: GroupSpec, camp: str) -> None:
    """Let the model's next games be against its partner as it is now, and the others."""
    others = list(spec.others[camp])
    total = sum(weight for _, weight in others)
    shares = [(player, (1 - spec.partner_share) * weight / total) for player, weight in others]
    partner_share = spec.partner_share if shares else 1.0
    model.get_env().env_method("set_opponent", [(partner.policy.freeze(), partner_share), *shares])  # type: ignore[union-attr]
