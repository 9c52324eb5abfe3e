"""The combination of the best (CAI, Fig. 6 (c)): teachers are distilled into one model, which then learns on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stable_baselines3.common.callbacks import ConvertCallback, EveryNTimesteps

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.distil import Lessons, distill
from hexwar_sb3.league.group import Opponents, TrainingSpec, env_steps, job_seed, one_thread
from hexwar_sb3.league.judge import Judge
from hexwar_sb3.league.member import CAMPS, Member, as_member, making

DISTILLED, LEARNED = "distilled", "learned"  # folders of the two stages


@dataclass(frozen=True, kw_only=True)
class HeirSpec(TrainingSpec):
    """All that the making of an heir depends on; leaves distilled/ and learned/."""

    camp: str
    teachers: tuple[Member, ...]
    opponents: Opponents
    lessons: Lessons
    panel: Sequence[object]  # whom its versions are judged against


def make_heir(spec: HeirSpec) -> None:
    """Distil and learn on (Fig. 6 (c)), and leave both policies: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: a teacher's folder is broken.
        TrainingError: a gradient is not finite; no folder is left.
    """
    if spec.folder.is_dir():
        return
    seed = job_seed(*spec.seed, CAMPS.index(spec.camp))
    teachers = [member.policy() for member in spec.teachers]
    env = {**spec.env, "side": spec.camp, "opponent": list(spec.opponents)}
    about = {**spec.about, "teachers": ", ".join(member.name for member in spec.teachers)}
    with making(spec.folder) as made, one_thread(), measured(made, "heir"):
        games = make_vec_env(
            "HexWarTask-v0", seed=seed_for(Purpose.TRAINING, seed), lower=teachers[0].lower, **env
        )
        student = QMIX("TaskPolicy", games, seed=seed, **spec.learner)
        distill(teachers, student, env, spec.lessons, seed)
        as_member(student, side=spec.camp, **about).save(made / DISTILLED)
        student.refit_mixer(env_steps(env, spec.refit_games))
        judge = Judge(spec.camp, spec.panel, spec.trial, about)
        _learn_on(student, spec, judge)
        judge.save(made / LEARNED)


def _learn_on(student: QMIX, spec: HeirSpec, judge: Judge) -> None:
    """Let the student learn, and show the judge what it is before and after every part of its games."""

    def see(*_: object) -> bool:
        judge.see(student)
        return True

    steps = env_steps(spec.env, spec.games)
    every = EveryNTimesteps(-(-steps // spec.rounds), ConvertCallback(see))
    see()
    student.learn(steps, every, reset_num_timesteps=False)
    see()
