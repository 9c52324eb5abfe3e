"""The best version of a model is kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.league.judge import Judge, Rivals
from hexwar_sb3.play.frozen import FrozenPolicy


@pytest.fixture
def model() -> QMIX:
    env = make_vec_env(n_envs=2, privileged_state=True, seed=0)
    return QMIX(
        "TaskPolicy", env, seed=0, learning_starts=0, batch_size=8, buffer_size=200, learning_rate=1e-3
    )


@dataclass(frozen=True, kw_only=True)
class Rigged(Terms):
    """Games that are won as often as is said."""

    shares: Iterator[float]

    def play_as(self, camp: str, player: object, opponent: object) -> CampResult:
        scores = np.zeros(100)
        scores[: int(100 * next(self.shares))] = 1.0
        return CampResult(scores, scores, scores.astype(np.int64))


def judge_of(*shares: float) -> Judge:
    """Meets one model, then two bots."""
    return Judge(
        "red",
        Rivals(["a model"], ["MA1", "MA2"], 0.5),
        Rigged(shares=iter(shares)),
        {"scenario": "plain"},
    )


def test_the_version_that_wins_most_is_kept(model: QMIX, tmp_path: Path) -> None:
    """The bot that it does worst against is half of it."""
    judge = judge_of(0.6, 0.9, 0.4, 0.6, 0.5, 0.5, 0.5, 0.9, 0.4)
    hashes = []
    for seed in range(3):
        model.policy.targets[0].data.fill_(seed)
        hashes.append(model.policy.freeze_settled().sha256)
        judge.see(model)
    judge.save(tmp_path / "best")

    kept = FrozenPolicy.load(tmp_path / "best")
    assert kept.sha256 == hashes[1]
    assert judge.score == pytest.approx(0.55)
    assert kept.about["side"] == "red"


def test_of_equal_versions_the_first_is_kept(model: QMIX) -> None:
    judge = judge_of(*(0.5,) * 6)
    judge.see(model)
    first = judge.best
    judge.see(model)

    assert judge.best is first


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_versions_play_in_their_own_camp(model: QMIX, camp: str) -> None:
    """MA1 wins every game against an untrained model, whoever is red."""
    judge = Judge(camp, Rivals([], ["MA1"], 0.5), Terms(games=4), {})
    judge.see(model)

    assert judge.score == 0.0
