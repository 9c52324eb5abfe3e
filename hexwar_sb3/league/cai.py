"""The combination of the best (CAI, Fig. 6 (c)): teachers are distilled into one model, which then learns on."""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.folders import making
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.distil import Lessons, distill
from hexwar_sb3.league.member import Member, as_member, leave
from hexwar_sb3.league.work import Opponents, Training, go_on, job_seed, one_thread

DISTILLED, LEARNED = "distilled", "learned"  # folders of the two stages


@dataclass(frozen=True, kw_only=True)
class CaiSpec(Training):
    """All that the making of a CAI depends on; leaves distilled/ and learned/."""

    side: str  # camp that it plays, or both
    teachers: tuple[Member, ...]
    lessons: Lessons
    opponents: Opponents  # of the teachers' games, and of its own


def make_cai(spec: CaiSpec) -> None:
    """Distil, and let it learn on (Fig. 6 (c)): a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: a teacher's folder is broken.
        TrainingError: a gradient is not finite.
    """
    if spec.folder.is_dir():
        return
    seed, teachers = job_seed(*spec.seed), [member.policy() for member in spec.teachers]
    env = {**spec.env, "side": spec.side, "opponent": list(spec.opponents)}
    about = {**spec.about, "side": spec.side, "teachers": ", ".join(one.name for one in spec.teachers)}
    with making(spec.folder) as made, one_thread(), measured(made, "training"):
        games = make_vec_env(
            TASK_ENV, seed=seed_for(Purpose.TRAINING, seed), **{**env, "lower": teachers[0].lower}
        )
        student = QMIX("TaskPolicy", games, seed=seed, **spec.learner)
        distill(teachers, student, env, spec.lessons, seed)
        as_member(student, **about).save(made / DISTILLED)
        go_on(student, spec)
        leave(student, made / LEARNED, **about)
