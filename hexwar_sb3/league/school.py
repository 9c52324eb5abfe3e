"""Expert iteration: against each opponent by itself somebody does better, and one student learns from all of them.

A standing order to a squad turns many a lost pairing into a won one, and random tasks hardly ever find it: seven pieces
would have to choose alike for many decisions. So for each opponent all orders are tried, the best is the teacher
against it, and the student learns to tell the opponents apart by what it sees (Anthony et al. 2017: expert
iteration; Ross et al. 2011: the student plays, the teachers say what they would do there).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any

from hexwar_sb3.algorithms.distillation import Lesson, teach
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.records import MAX_SIDE
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.files import read_json, write_json
from hexwar_sb3.league.member import CAMPS, Member, as_member, making
from hexwar_sb3.league.work import Training, begin, env_steps, job_seed, one_thread
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder, standing_orders
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.ruleset import default_rules

Candidate = FrozenPolicy | LedPolicy


@dataclass(frozen=True, kw_only=True)
class School:
    """How teachers are found, and how the student learns from them."""

    lessons: Lessons = field(default_factory=lambda: Lessons(games=64, epsilon=0.03, updates=1_500))
    rounds: int = 4  # of lessons: in the first the teachers play, then the student
    free_ticks: int = 300  # at a game's start, without orders: all teachers open alike, and the enemy is seen
    trials: tuple[tuple[int, int], ...] = ((16, 10), (50, 4), (150, 1))  # games, how many candidates go on
    gain: float = 0.03  # in win rate, that another teacher must be better by than the student itself

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is out of its range.
        """
        check_whole("rounds", self.rounds, least=0)
        check_whole("free_ticks", self.free_ticks, least=0)
        for games, left in self.trials:
            check_whole("games of a trial", games, least=1)
            check_whole("candidates after a trial", left, least=1)


@dataclass(frozen=True)
class Class:
    """Lessons of one teacher in games against one opponent."""

    teacher: Path  # a policy's folder
    order: StandingOrder | None  # that it follows
    opponent: object  # a player
    weight: float  # of these lessons

    def who(self) -> Candidate:
        """Read the teacher.

        Raises:
            PolicyFileError: its folder is broken.
        """
        policy = FrozenPolicy.load(self.teacher, rules=default_rules().hash)
        return policy if self.order is None else LedPolicy(policy, self.order)


@dataclass(frozen=True)
class Found:
    """Who is best against an opponent."""

    elder: int  # which of the policies that were tried
    order: StandingOrder | None  # that it follows
    win_rate: float  # in the last trial
    own: float  # the first policy's, by itself


def best_teacher(elders: Sequence[Path], opponent: object, camp: str, school: School, terms: Terms) -> Found:
    """Who is best against one opponent: one of some policies, or the first of them led by an order.

    After each trial the better candidates go on (successive halving). The first policy always does, and is taken
    unless another candidate wins more often by `school.gain`.

    Args:
        elders: folders of policies of that camp.
        opponent: a player of the other.
        camp: "red" or "blue".
        school: trials and orders.
        terms: of the games; their number and seed are the trials'.

    Raises:
        PolicyFileError: an elder's folder is broken.
    """
    scenario = load_world(terms.scenario).scenario
    spots = len(scenario.points) + terms.spots
    policies = [FrozenPolicy.load(folder, rules=default_rules().hash) for folder in elders]
    given = standing_orders(scenario, Camp[camp.upper()], spots, school.free_ticks)
    candidates: list[tuple[int, StandingOrder | None]] = [
        *((k, None) for k in range(len(elders))),
        *((0, one) for one in given),
    ]
    best = Found(0, None, 0.0, 0.0)
    for part, (games, left) in enumerate(school.trials):
        trial = replace(terms, games=games, seed=job_seed(terms.seed, part))
        results = [
            _play(trial, policies[k] if order is None else LedPolicy(policies[k], order), opponent, camp)
            for k, order in candidates
        ]
        ranked = sorted(range(len(candidates)), key=lambda n: results[n], reverse=True)
        own, top = results[0][0], results[ranked[0]][0]
        is_better = top >= own + school.gain
        best = Found(*candidates[ranked[0]], top, own) if is_better else Found(0, None, own, own)
        candidates = [candidates[n] for n in dict.fromkeys([0, *ranked[:left]])]
    return best


def _play(terms: Terms, player: object, opponent: object, camp: str) -> tuple[float, float]:
    """Win rate and mean margin."""
    found = terms.play(player, opponent).red if camp == "red" else terms.play(opponent, player).blue
    return found.win_rate.value, found.mean_margin.value


@dataclass(frozen=True, kw_only=True)
class Search:
    """All that the search for a teacher depends on, and the file that it leaves."""

    elders: tuple[Path, ...]
    opponent: object
    camp: str
    school: School
    terms: Terms
    file: Path


def search(spec: Search) -> None:
    """Find a teacher and write it down: a function of `spec` alone, in any process."""
    if spec.file.exists():
        return
    with one_thread():
        found = best_teacher(spec.elders, spec.opponent, spec.camp, spec.school, spec.terms)
    spec.file.parent.mkdir(parents=True, exist_ok=True)
    write_json(spec.file, {"opponent": name_of(spec.opponent), **asdict(found)})


def name_of(opponent: object) -> str:
    """What a bot or a model is called, wherever its folder lies."""
    place = PurePath(str(opponent))
    return place.parent.name if place.name in CAMPS else place.name


def read_class(spec: Search, weight: float) -> Class:
    """What `search` found.

    Raises:
        FileFormatError: the file is missing or broken.
    """
    found = read_json(spec.file)
    elder, order = found.get("elder"), found.get("order")
    if type(elder) is not int or elder not in range(len(spec.elders)) or not _is_order(order):
        said = str(found)[:80]
        raise FileFormatError(spec.file, "elder and order", found=said, expected="a teacher that was found")
    given = None if order is None else StandingOrder(**{**order, "pieces": tuple(order["pieces"])})
    return Class(spec.elders[elder], given, spec.opponent, weight)


def _is_order(values: object) -> bool:
    """Whether a JSON value is no order, or has the fields of one, whole numbers that mean something."""
    if values is None:
        return True
    if not isinstance(values, dict) or set(values) != {"pieces", "spot", "ticks_left"}:
        return False
    pieces = values["pieces"]
    if not isinstance(pieces, list) or any(piece not in range(MAX_SIDE) for piece in pieces):
        return False
    return all(
        type(number) is int and number >= 0 for number in (*pieces, values["spot"], values["ticks_left"])
    )


@dataclass(frozen=True, kw_only=True)
class Pupil(Training):
    """All that a model's time at school depends on, and the folder that it leaves."""

    member: Member
    classes: Sequence[Class]
    school: School


def go_to_school(spec: Pupil) -> None:
    """Let a model of a league learn from its teachers: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: its folder or a teacher's is broken.
    """
    if spec.folder.is_dir():
        return
    seed, env = job_seed(*spec.seed), {**spec.env, "side": spec.member.camp}
    with making(spec.folder) as made, one_thread():
        student = begin(spec.member.policy(), {**env, "opponent": "MA1"}, spec.learner, seed)
        attend(student, spec.classes, env, spec.school, seed)
        as_member(student, side=spec.member.camp, **spec.about).save(made)


def attend(
    student: QMIX,
    classes: Sequence[Class],
    env: Mapping[str, Any],
    school: School,
    seed: int,
    see: Callable[[QMIX], object] = id,
) -> None:
    """Let a student learn from its teachers, each in games against the opponent that it knows how to beat.

    Args:
        student: its agent network learns, the mixer stays (`QMIX.refit_mixer` fits it again).
        classes: whose teachers teach.
        env: settings of the task env, the student's side among them.
        school: how.
        seed: in 0..999999.
        see: called with the student after every round.
    """
    lower, lessons = student.policy.lower, school.lessons
    games = [
        make_vec_env(
            "HexWarTask-v0",
            seed=seed_for(Purpose.TRAINING, job_seed(seed, k)),
            **{**env, "opponent": one.opponent, "lower": lower},
        )
        for k, one in enumerate(classes)
    ]
    teachers, learned = [one.who() for one in classes], [Lesson() for _ in classes]
    steps = env_steps(env, lessons.games)
    for part in range(school.rounds):
        actor = as_member(student) if part else None
        for k, teacher in enumerate(teachers):
            met = teach(teacher, games[k], steps, lessons.epsilon, job_seed(seed, part, k), actor)
            learned[k].pages.extend(met.pages)
        lessons.study(learned, student.policy, job_seed(seed, part), [one.weight for one in classes])
        see(student)
