"""Expert iteration: the best teacher is found, written down, read again, and learned from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError, FileFormatError, PolicyFileError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.league import school as of_school
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.school import Class, Found, School, Search, attend, best_teacher, read_class, search
from hexwar_sb3.league.work import env_settings, job_seed
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder

GOOD = StandingOrder(pieces=(0, 1, 2, 3), spot=5, ticks_left=1500)
Play = Callable[[Terms, Any, object, str], tuple[float, float]]


@pytest.fixture
def elders(starters: dict[str, Path]) -> list[Path]:
    return [starters["one"], starters["two"]]


def scored(monkeypatch: pytest.MonkeyPatch, order: float, elder: float = 0.0, own: float = 0.5) -> list[int]:
    """Let one order, another elder and the first policy win so often, and all else never; games of every trial."""
    games: list[int] = []
    seen: list[str] = []

    def play(terms: Terms, player: Any, *_: object) -> tuple[float, float]:
        games.append(terms.games)
        if isinstance(player, LedPolicy):
            return (order if player.order == GOOD else 0.0), 0.0
        seen.append(player.sha256)
        return (own if player.sha256 == seen[0] else elder), 0.0

    monkeypatch.setattr(of_school, "_play", play)
    return games


def test_the_order_that_wins_most_is_found(monkeypatch: pytest.MonkeyPatch, elders: list[Path]) -> None:
    games = scored(monkeypatch, order=0.9, elder=0.8)
    school = School(trials=((2, 3), (5, 1)))

    assert best_teacher(elders, "MA1", "red", school, Terms(games=1)) == Found(0, GOOD, 0.9, 0.5)
    assert games == [2] * (2 + 6 * 8) + [5] * 3  # these two and the policy itself went on


def test_another_policy_may_be_the_best(monkeypatch: pytest.MonkeyPatch, elders: list[Path]) -> None:
    scored(monkeypatch, order=0.6, elder=0.8)
    assert best_teacher(elders, "MA1", "red", School(), Terms(games=1)) == Found(1, None, 0.8, 0.5)


@pytest.mark.parametrize(("order", "found"), [(0.54, None), (0.56, GOOD)])
def test_a_small_gain_is_none(
    monkeypatch: pytest.MonkeyPatch, elders: list[Path], order: float, found: StandingOrder | None
) -> None:
    scored(monkeypatch, order=order)
    assert best_teacher(elders, "MA1", "red", School(gain=0.05), Terms(games=1)).order == found


def test_candidates_play_in_their_own_camp(elders: list[Path]) -> None:
    terms = Terms(games=4, seed=job_seed(0, 0))
    first = terms.play(elders[0], "nearest").red.win_rate.value
    second = terms.play("nearest", elders[0]).blue.win_rate.value
    school = School(trials=((4, 1),), gain=1.0)

    assert best_teacher(elders[:1], "nearest", "red", school, Terms(games=1)).own == first
    assert best_teacher(elders[:1], "nearest", "blue", school, Terms(games=1)).own == second


def wanted(elders: list[Path], file: Path) -> Search:
    return Search(
        elders=tuple(elders), opponent="MA1", camp="red", school=School(), terms=Terms(games=1), file=file
    )


def test_what_was_found_is_written_down_once_and_read_again(
    monkeypatch: pytest.MonkeyPatch, elders: list[Path], tmp_path: Path
) -> None:
    spec = wanted(elders, tmp_path / "new" / "0.json")
    games = scored(monkeypatch, order=0.9)
    search(spec)
    played = len(games)
    search(spec)

    assert len(games) == played > 0
    assert read_class(spec, 0.25) == Class(elders[0], GOOD, "MA1", 0.25)
    assert isinstance(read_class(spec, 0.25).who(), LedPolicy)


FOUND = '{"elder": 1, "order": null}'
BROKEN = {
    "not JSON": "{",
    "no elder": '{"order": null}',
    "an unknown elder": '{"elder": 2, "order": null}',
    "a truth for an elder": '{"elder": true, "order": null}',
    "a list for an elder": '{"elder": [], "order": null}',
    "no order's fields": '{"elder": 0, "order": {"pieces": [0]}}',
    "a piece that nobody has": '{"elder": 0, "order": {"pieces": [99], "spot": 0, "ticks_left": 1500}}',
    "a number for pieces": '{"elder": 0, "order": {"pieces": 3, "spot": 0, "ticks_left": 1500}}',
    "a text for a spot": '{"elder": 0, "order": {"pieces": [0], "spot": "0", "ticks_left": 1500}}',
    "less than nothing": '{"elder": 0, "order": {"pieces": [0], "spot": -1, "ticks_left": 1500}}',
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_named(what: str, elders: list[Path], tmp_path: Path) -> None:
    spec = wanted(elders, tmp_path / "0.json")
    spec.file.write_text(BROKEN[what])
    with pytest.raises(FileFormatError, match=r"0\.json"):
        read_class(spec, 1.0)
    spec.file.write_text(FOUND)

    assert read_class(spec, 1.0).teacher == elders[1]


def test_a_teacher_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(PolicyFileError):
        Class(tmp_path / "nobody", None, "MA1", 1.0).who()


def test_a_student_learns_whose_order_it_is(elders: list[Path]) -> None:
    """Two classes, two orders from the first tick on, and none after a while: by itself it never chose like that."""
    env = {**env_settings(Terms(games=1), 4), "side": "red"}
    student = QMIX(
        "TaskPolicy",
        make_vec_env(**{**env, "opponent": "MA1"}),
        seed=5,
        buffer_size=10,
        policy_kwargs={"hidden": 32},
    )
    order = StandingOrder(pieces=(0, 1), spot=3, ticks_left=1800)
    classes = [Class(elders[0], order, "MA1", 0.5), Class(elders[0], order, "all-main", 0.5)]
    school = School(lessons=Lessons(games=8, epsilon=0.1, updates=150, batch_size=32, tau=0.02), rounds=2)
    led, seen = classes[0].who(), []

    def agreement() -> float:
        obs: Any = make_vec_env(n_envs=8, seed=9, privileged_state=True, reward="net").reset()
        return float((student.policy.greedy(obs)[:, :2] == led.act(obs)[:, :2]).mean())

    before = agreement()
    attend(student, classes, env, school, 1, lambda _: seen.append(agreement()))

    assert len(seen) == 2
    assert seen[-1] > max(0.9, before)


def test_the_same_seed_gives_the_same_student(elders: list[Path]) -> None:
    env = {**env_settings(Terms(games=1), 2), "side": "blue"}
    school = School(lessons=Lessons(games=2, updates=3, batch_size=8), rounds=2)

    def learned(seed: int) -> FrozenPolicy:
        student = QMIX("TaskPolicy", make_vec_env(**{**env, "opponent": "MA1"}), seed=5, buffer_size=10)
        attend(student, [Class(elders[0], None, "MA2", 1.0)], env, school, seed)
        return student.policy.freeze()

    assert learned(1).sha256 == learned(1).sha256 != learned(2).sha256


@pytest.mark.parametrize(
    "wrong", [{"rounds": -1}, {"free_ticks": -1}, {"trials": ((0, 1),)}, {"trials": ((1, 0),)}]
)
def test_a_wrong_number_is_named(wrong: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match="must be an integer"):
        replace(School(), **wrong)


def test_the_untrained_differ(elders: list[Path]) -> None:
    """What the tests above tell apart."""
    first, second = (FrozenPolicy.load(folder) for folder in elders)
    assert first.sha256 != second.sha256
    assert not np.array_equal(first.weights["value.weight"], second.weights["value.weight"])
