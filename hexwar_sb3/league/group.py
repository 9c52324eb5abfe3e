"""One group of a league: a red and a blue model train against each other and against others (Fig. 6 (b))."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import SEEDS_PER_PURPOSE, Purpose, seed_for
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.judge import Judge
from hexwar_sb3.league.member import CAMPS, Member, making

PAIRS = (CAMPS, CAMPS[::-1])  # who learns, and who is met
Opponents = Sequence[tuple[object, float]]  # player, weight


@dataclass(frozen=True, kw_only=True)
class TrainingSpec:
    """What every training of a league depends on, and the folder that it leaves."""

    games: int  # that a model learns from
    rounds: int  # parts of them; after each a version is judged
    refit_games: int  # before them, in which the mixer alone learns: it is new, and the replay is empty
    trial: Terms  # of a version's games against each of its panel
    seed: tuple[int, ...]  # numbers that name the training
    folder: Path  # gets the policies
    env: Mapping[str, Any]  # settings of the task env
    learner: Mapping[str, Any]  # arguments of QMIX
    about: Mapping[str, str]  # texts for the policies' folders


@dataclass(frozen=True, kw_only=True)
class GroupSpec(TrainingSpec):
    """All that the training of a group depends on: in each round first red and then blue learns; leaves red/ and blue/."""

    members: Mapping[str, Member]  # by camp: who trains
    others: Mapping[str, Opponents]  # by camp: whom the model of that camp meets beside its partner
    partner_share: float  # of the games, against the partner as it is now
    panels: Mapping[str, Sequence[object]]  # by camp: whom its versions are judged against

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
    models = {camp: _start(spec, camp) for camp in CAMPS}
    judges = {camp: Judge(camp, spec.panels[camp], spec.trial, spec.about) for camp in CAMPS}
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


def env_settings(terms: Terms, n_envs: int) -> dict[str, Any]:
    """Settings of the task env for games on these terms."""
    return {
        "scenario": terms.scenario,
        "decision_ticks": terms.decision_ticks,
        "spots": terms.spots,
        "decisions": "event" if terms.early else "fixed",
        "reward": "net",
        "n_envs": n_envs,
        "privileged_state": True,
    }


def env_steps(env: Mapping[str, Any], games: int) -> int:
    """Env steps that make so many games."""
    return games * load_world(env["scenario"]).scenario.game_ticks // int(env["decision_ticks"])


def job_seed(*numbers: int) -> int:
    """Seed in 0..999999 for a job, from the numbers that name it."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0]) % SEEDS_PER_PURPOSE


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread: as fast as two here, and jobs run side by side."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
