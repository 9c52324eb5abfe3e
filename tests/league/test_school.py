"""School: a plan is found, written down, read again, and learned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.member import Member
from hexwar_sb3.league.plans import Plan, Planner, Planning
from hexwar_sb3.league.school import School, Search, attend, best_plan, read_plan, search
from hexwar_sb3.league.work import env_settings
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder

GOOD = StandingOrder(pieces=(0, 1, 2, 3), spot=5, ticks_left=1500)


@pytest.fixture
def members(starters: dict[str, Path]) -> list[Member]:
    return [Member("red", name, starters[name]) for name in ("one", "two")]


def wanted(member: Member, file: Path) -> Search:
    return Search(
        policy=member,
        opponents=[("MA1", 0.75), ("MA2", 0.25)],
        planning=Planning(),
        terms=Terms(games=1),
        file=file,
    )


def test_what_was_found_is_written_down_once_and_read_again(
    monkeypatch: pytest.MonkeyPatch, members: list[Member], tmp_path: Path
) -> None:
    spec, plan = wanted(members[0], tmp_path / "new" / "one.json"), Plan((GOOD, None), (0.5, 0.75))
    monkeypatch.setattr(Planner, "plan", lambda _: plan)
    search(spec)
    monkeypatch.setattr(Planner, "plan", None)
    search(spec)

    assert read_plan(spec) == plan


def test_a_plan_is_a_function_of_its_spec(members: list[Member], tmp_path: Path) -> None:
    planning = Planning(times=(300,), trials=((1, 1),), sights=2)
    specs = [replace(wanted(members[0], tmp_path / f"{k}.json"), planning=planning) for k in range(2)]
    for spec in specs:
        search(spec)

    assert specs[0].file.read_text() == specs[1].file.read_text()


FOUND = '{"orders": [null, null], "win_rates": [0.5, 0.25]}'
BROKEN = {
    "not JSON": "{",
    "no orders": '{"win_rates": [0.5, 0.25]}',
    "too few orders": '{"orders": [null], "win_rates": [0.5, 0.25]}',
    "a text for a rate": '{"orders": [null, null], "win_rates": ["0.5", 0.25]}',
    "more than all": '{"orders": [null, null], "win_rates": [0.5, 1.25]}',
    "not a number": '{"orders": [null, null], "win_rates": [NaN, 0.25]}',
    "no order's fields": '{"orders": [{"pieces": [0]}, null], "win_rates": [0.5, 0.25]}',
    "a piece that nobody has": FOUND.replace("null,", '{"pieces": [99], "spot": 0, "ticks_left": 1500},'),
    "a number for pieces": FOUND.replace("null,", '{"pieces": 3, "spot": 0, "ticks_left": 1500},'),
    "a text for a spot": FOUND.replace("null,", '{"pieces": [0], "spot": "0", "ticks_left": 1500},'),
    "less than nothing": FOUND.replace("null,", '{"pieces": [0], "spot": -1, "ticks_left": 1500},'),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_named(what: str, members: list[Member], tmp_path: Path) -> None:
    spec = wanted(members[0], tmp_path / "one.json")
    spec.file.write_text(BROKEN[what])
    with pytest.raises(FileFormatError, match=r"one\.json"):
        read_plan(spec)
    spec.file.write_text(FOUND)

    assert read_plan(spec) == Plan((None, None), (0.5, 0.25))


@pytest.mark.parametrize(("rate", "place"), [(0.5, 0), (0.53, 0), (0.55, 1)])
def test_anothers_plan_must_be_better(rate: float, place: int, members: list[Member], tmp_path: Path) -> None:
    specs = [wanted(member, tmp_path / f"{member.name}.json") for member in members]
    specs[0].file.write_text('{"orders": [null, null], "win_rates": [0.5, 0.5]}')
    specs[1].file.write_text(f'{{"orders": [null, null], "win_rates": [{rate}, 0.5]}}')

    assert best_plan(specs)[0] == members[place]


def test_a_student_learns_whose_order_it_is(members: list[Member]) -> None:
    """Two opponents, one order from the first tick on: by itself the student never chose like that."""
    env = {**env_settings(Terms(games=1), 4), "side": "red"}
    student = QMIX(
        "TaskPolicy",
        make_vec_env(**{**env, "opponent": "MA1"}, seed=0),
        seed=5,
        buffer_size=10,
        policy_kwargs={"hidden": 32},
    )
    order, policy = StandingOrder(pieces=(0, 1), spot=3, ticks_left=1800), members[0].policy()
    school = School(lessons=Lessons(games=8, epsilon=0.1, updates=150, batch_size=32, tau=0.02), rounds=2)
    led, seen = LedPolicy(policy, order), []

    def agreement() -> float:
        obs: Any = make_vec_env(n_envs=8, seed=9, privileged_state=True, reward="net").reset()
        return float((student.policy.greedy(obs)[:, :2] == led.act(obs)[:, :2]).mean())

    before, plan = agreement(), Plan((order, order), (0.5, 0.5))
    opponents = [("MA1", 0.5), ("all-main", 0.5)]
    attend(student, policy, plan, opponents, env, school, 1, lambda _: seen.append(agreement()))

    assert len(seen) == 2
    assert seen[-1] > max(0.9, before)


def test_the_same_seed_gives_the_same_student(members: list[Member]) -> None:
    env = {**env_settings(Terms(games=1), 2), "side": "blue"}
    school = School(lessons=Lessons(games=2, updates=3, batch_size=8), rounds=2)

    def learned(seed: int) -> FrozenPolicy:
        student = QMIX(
            "TaskPolicy", make_vec_env(**{**env, "opponent": "MA1"}, seed=0), seed=5, buffer_size=10
        )
        attend(student, members[0].policy(), Plan((None,), (0.5,)), [("MA2", 1.0)], env, school, seed)
        return student.policy.freeze()

    assert learned(1).sha256 == learned(1).sha256 != learned(2).sha256


def test_a_wrong_number_of_rounds_is_named() -> None:
    with pytest.raises(ConfigError, match="rounds must be an integer"):
        School(rounds=-1)


def test_the_untrained_differ(members: list[Member]) -> None:
    """What the tests above tell apart."""
    first, second = (member.policy() for member in members)
    assert first.sha256 != second.sha256
    assert not np.array_equal(first.weights["value.weight"], second.weights["value.weight"])
