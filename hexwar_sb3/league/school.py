"""School: a policy that follows its plan teaches a student, who then needs no plan.

A standing order to a squad turns many a lost pairing into a won one, and random tasks hardly ever find it: seven pieces
would have to choose alike for many decisions. So orders are tried (`league.plans`), and a student learns what the
policy so led does against each opponent (Anthony et al. 2017: expert iteration; Ross et al. 2011: the student plays,
the teachers say what they would do there).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path, PurePath
from typing import Any

from hexwar_sb3.algorithms.distillation import Lesson, teach
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.records import MAX_SIDE
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.files import write_json
from hexwar_sb3.folders import making
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.member import CAMPS, Member, as_member
from hexwar_sb3.league.plans import Plan, Planner, Planning
from hexwar_sb3.league.work import Opponents, Training, begin, env_steps, job_seed, one_thread
from hexwar_sb3.maps.scenario import MAX_GAME_TICKS
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder
from hexwar_sb3.reading import read_json
from hexwar_sb3.tasks.records import MAX_TASKS


@dataclass(frozen=True, kw_only=True)
class School:
    """How plans are found, and how the student learns from them."""

    lessons: Lessons = field(default_factory=lambda: Lessons(games=64, epsilon=0.03, updates=1_500))
    rounds: int = 2  # of lessons: in the first the teachers play, then the student
    planning: Planning = field(default_factory=Planning)

    def __post_init__(self) -> None:
        """Check the number.

        Raises:
            ConfigError: it is out of its range.
        """
        check_whole("rounds", self.rounds, least=0)


@dataclass(frozen=True, kw_only=True)
class Search:
    """All that the search for a plan depends on, and the file that it leaves."""

    policy: Member
    opponents: Opponents
    planning: Planning
    terms: Terms
    file: Path

    def weights(self) -> list[float]:
        """Of the opponents."""
        return [weight for _, weight in self.opponents]


def search(spec: Search) -> None:
    """Find a policy's plan and write it down: a function of `spec` alone, in any process.

    Raises:
        PolicyFileError: the policy's folder is broken.
    """
    if spec.file.exists():
        return
    with one_thread():
        planner = Planner(spec.policy.policy(), spec.policy.camp, spec.opponents, spec.planning, spec.terms)
        plan = planner.plan()
    write_json(spec.file, {"opponents": [name_of(one) for one, _ in spec.opponents], **asdict(plan)})


def read_plan(spec: Search) -> Plan:
    """What `search` found.

    Raises:
        FileFormatError: the file is missing or broken.
    """
    found = read_json(spec.file)
    orders, rates = found.get("orders"), found.get("win_rates")
    names = [name_of(one) for one, _ in spec.opponents]
    if not (
        isinstance(orders, list)
        and isinstance(rates, list)
        and len(orders) == len(rates) == len(spec.opponents)
        and all(_is_order(one) for one in orders)
        and all(isinstance(rate, float) and 0.0 <= rate <= 1.0 for rate in rates)
        and found.get("opponents", names) == names
    ):
        expected = f"{len(names)} orders and win rates against {names}"
        raise FileFormatError(spec.file, "plan", found=str(found)[:80], expected=expected)
    read = [one and StandingOrder(**{**one, "pieces": tuple(one["pieces"])}) for one in orders]
    return Plan(tuple(read), tuple(rates))


def _is_order(values: object) -> bool:
    """Whether a JSON value is no order, or has the fields of one, whole numbers that mean something."""
    if values is None:
        return True
    if not isinstance(values, dict) or set(values) != {"pieces", "spot", "ticks_left"}:
        return False
    pieces = values["pieces"]
    if not isinstance(pieces, list) or any(piece not in range(MAX_SIDE) for piece in pieces):
        return False
    spot, ticks_left = values["spot"], values["ticks_left"]
    is_known = spot in range(MAX_TASKS) and ticks_left in range(MAX_GAME_TICKS + 1)
    return is_known and all(type(number) is int for number in (*pieces, spot, ticks_left))


def best_plan(searches: Sequence[Search]) -> tuple[Member, Plan]:
    """Who has the best plan; the first, unless another's is better by the gain that an order must bring.

    Raises:
        FileFormatError: a file is missing or broken.
    """
    plans = [read_plan(spec) for spec in searches]
    worth = [plan.worth(spec.weights()) for plan, spec in zip(plans, searches, strict=True)]
    top = max(range(len(plans)), key=lambda k: worth[k])
    k = top if worth[top] >= worth[0] + searches[0].planning.gain else 0
    return searches[k].policy, plans[k]


def name_of(opponent: object) -> str:
    """What a bot or a model is called, wherever its folder lies."""
    place = PurePath(str(opponent))
    return place.parent.name if place.name in CAMPS else place.name


@dataclass(frozen=True, kw_only=True)
class Pupil(Training):
    """All that a time at school depends on, and the folder that it leaves."""

    searches: Sequence[Search]  # done: of the pupil, and of others whose plan it may learn instead
    school: School


def go_to_school(spec: Pupil) -> None:
    """Let a model of a league learn the best of some plans, as whose it begins: a function of `spec` alone, in any process.

    Raises:
        FileFormatError: a file of the searches is missing or broken.
        PolicyFileError: a policy's folder is broken.
    """
    if spec.folder.is_dir():
        return
    member, plan = best_plan(spec.searches)
    seed, env = job_seed(*spec.seed), {**spec.env, "side": member.camp}
    with making(spec.folder) as made, one_thread():
        policy = member.policy()
        student = begin(policy, {**env, "opponent": "MA1"}, spec.learner, seed)
        if any(plan.orders):  # else it plays as planned already
            attend(student, policy, plan, spec.searches[0].opponents, env, spec.school, seed)
        as_member(student, side=member.camp, **spec.about).save(made)


def attend(
    student: QMIX,
    policy: FrozenPolicy,
    plan: Plan,
    opponents: Opponents,
    env: Mapping[str, Any],
    school: School,
    seed: int,
    see: Callable[[QMIX], object] = id,
) -> None:
    """Let a student learn a policy's plan.

    Args:
        student: its agent network learns, the mixer stays (`QMIX.refit_mixer` fits it again).
        policy: that the plan is for; led by its orders it teaches.
        plan: an order or none against each opponent.
        opponents: of the lessons, with their weights.
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
            **{**env, "opponent": opponent, "lower": lower},
        )
        for k, (opponent, _) in enumerate(opponents)
    ]
    teachers = [policy if order is None else LedPolicy(policy, order) for order in plan.orders]
    learned, weights = [Lesson() for _ in teachers], [weight for _, weight in opponents]
    steps = env_steps(env, lessons.games)
    for part in range(school.rounds):
        actor = as_member(student) if part else None
        for k, teacher in enumerate(teachers):
            met = teach(teacher, games[k], steps, lessons.epsilon, job_seed(seed, part, k), actor)
            learned[k].pages.extend(met.pages)
        lessons.study(learned, student.policy, job_seed(seed, part), weights)
        see(student)
