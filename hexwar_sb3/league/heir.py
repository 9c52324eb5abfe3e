"""The combination of the best (CAI, Fig. 6 (c)): teachers are distilled into one model, which goes to school and learns on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import BOTS, Terms
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.folders import making
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.distil import Lessons, distill
from hexwar_sb3.league.judge import Judge, Rivals
from hexwar_sb3.league.member import CAMPS, Member, as_member
from hexwar_sb3.league.school import School, Search, attend, best_plan, search
from hexwar_sb3.league.work import Opponents, Training, begin, env_steps, job_seed, one_thread

TAUGHT, DISTILLED, SCHOOLED = "taught", "distilled", "schooled"  # folders of the first two stages
LEARNED = "learned"  # and of the last


@dataclass(frozen=True)
class Practice:
    """How an heir learns on after school, in its own games."""

    games: int = 6_000
    rounds: int = 6  # parts of them; before the first and after each a version is judged
    bots_share: float = 0.6  # of them, against MA1 and MA2; the rest against whom it met at school
    anchor: float = 0.02  # weight of staying near what was taught
    learning_rate: float = 5e-4
    refit_games: int = 100  # before them, in which the mixer alone learns
    trial_games: int = 200  # of a version against each of its rivals

    def opponents(self, met: Opponents) -> Opponents:
        """Whom it meets: the two bots, and those others whom it has met."""
        others = [(player, weight) for player, weight in met if player not in BOTS]
        total = sum(weight for _, weight in others)
        bots = [(bot, self.bots_share / len(BOTS)) for bot in BOTS]
        return [*bots, *((player, (1 - self.bots_share) * weight / total) for player, weight in others)]


@dataclass(frozen=True, kw_only=True)
class HeirSpec(Training):
    """All that the making of an heir depends on; leaves taught/ (distilled/ and schooled/) and learned/."""

    camp: str
    teachers: tuple[Member, ...]  # who are distilled
    elders: tuple[Member, ...]  # one of whom teaches at school if its plan is better than the student's own
    lessons: Lessons
    school: School
    practice: Practice
    opponents: Opponents  # of the teachers' games, of the school's lessons, and of its own
    rivals: Rivals  # whom its versions are judged against
    trial: Terms  # of a version's games against each of them, at school

    @property
    def env_settings(self) -> dict[str, Any]:
        """Of its games."""
        return {**self.env, "side": self.camp, "opponent": list(self.opponents)}

    @property
    def texts(self) -> dict[str, str]:
        """For the policies' folders."""
        return {**self.about, "teachers": ", ".join(member.name for member in self.teachers)}


def make_heir(spec: HeirSpec) -> None:
    """Distil, teach, and let it learn on (Fig. 6 (c)); leaves the policies: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: a teacher's folder is broken.
        TrainingError: a gradient is not finite.
    """
    seed = job_seed(*spec.seed, CAMPS.index(spec.camp))
    with one_thread():
        if not (spec.folder / TAUGHT).is_dir():
            _teach(spec, seed)
        if not (spec.folder / LEARNED).is_dir():
            _practise(spec, seed)


def _teach(spec: HeirSpec, seed: int) -> None:
    """Distil the teachers into a student, and send it to school."""
    teachers, env = [member.policy() for member in spec.teachers], spec.env_settings
    with making(spec.folder / TAUGHT) as made, measured(spec.folder, "teaching"):
        games = make_vec_env(
            "HexWarTask-v0", seed=seed_for(Purpose.TRAINING, seed), lower=teachers[0].lower, **env
        )
        student = QMIX("TaskPolicy", games, seed=seed, **spec.learner)
        distill(teachers, student, env, spec.lessons, seed)
        as_member(student, side=spec.camp, **spec.texts).save(made / DISTILLED)
        judge = Judge(spec.camp, spec.rivals, spec.trial, spec.texts)
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
        judge.save(made / SCHOOLED)


def _practise(spec: HeirSpec, seed: int) -> None:
    """Let it learn on, held near what it was taught; leave its best version."""
    practice, taught = spec.practice, Member(spec.camp, SCHOOLED, spec.folder / TAUGHT / SCHOOLED)
    with making(spec.folder / LEARNED) as made, measured(spec.folder, "practice"):
        learner = {**spec.learner, "learning_rate": practice.learning_rate}
        env = {**spec.env_settings, "opponent": practice.opponents(spec.opponents)}
        model = begin(taught.policy(), env, learner, seed, practice.anchor)
        judge = Judge(spec.camp, spec.rivals, replace(spec.trial, games=practice.trial_games), spec.texts)
        judge.see(model)
        model.refit_mixer(env_steps(spec.env, practice.refit_games))
        for part in range(practice.rounds):
            games = practice.games * (part + 1) // practice.rounds - practice.games * part // practice.rounds
            model.learn(env_steps(spec.env, games), reset_num_timesteps=False)
            judge.see(model)
        judge.save(made)
