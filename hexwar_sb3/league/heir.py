"""The combination of the best (CAI, Fig. 6 (c)): teachers are distilled into one model, which then goes to school."""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.distil import Lessons, distill
from hexwar_sb3.league.judge import Judge, Rivals
from hexwar_sb3.league.member import CAMPS, Member, as_member, making
from hexwar_sb3.league.school import School, Search, attend, best_plan, search
from hexwar_sb3.league.work import Opponents, Training, job_seed, one_thread

DISTILLED, LEARNED = "distilled", "learned"  # folders of the two stages


@dataclass(frozen=True, kw_only=True)
class HeirSpec(Training):
    """All that the making of an heir depends on; leaves distilled/ and learned/."""

    camp: str
    teachers: tuple[Member, ...]  # who are distilled
    elders: tuple[Member, ...]  # one of whom teaches at school if its plan is better than the student's own
    lessons: Lessons
    school: School
    opponents: Opponents  # of the teachers' games, and of the school's lessons
    rivals: Rivals  # whom its versions are judged against
    trial: Terms  # of a version's games against each of them


def make_heir(spec: HeirSpec) -> None:
    """Distil and teach on (Fig. 6 (c)), and leave both policies: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: a teacher's folder is broken.
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
        judge = Judge(spec.camp, spec.rivals, spec.trial, about)
        judge.see(student)
        searches = [
            Search(
                policy=elder,
                opponents=spec.opponents,
                planning=spec.school.planning,
                terms=spec.trial,
                file=made / f"plan_{k}.json",
            )
            for k, elder in enumerate((Member(spec.camp, DISTILLED, made / DISTILLED), *spec.elders))
        ]
        for one in searches:
            search(one)
        elder, plan = best_plan(searches)
        attend(student, elder.policy(), plan, spec.opponents, env, spec.school, seed, judge.see)
        judge.save(made / LEARNED)
