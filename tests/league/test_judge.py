"""The best version of a model is kept."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.league.judge import Judge
from hexwar_sb3.play.frozen import FrozenPolicy


@pytest.fixture
def model() -> QMIX:
    env = make_vec_env(n_envs=2, privileged_state=True, seed=0)
    return QMIX(
        "TaskPolicy", env, seed=0, learning_starts=0, batch_size=8, buffer_size=200, learning_rate=1e-3
    )


class Scorer(Judge):
    """Its versions win as often as they are told to."""

    shares: Iterator[float] = iter(())

    def _play(self, version: FrozenPolicy, other: object) -> CampResult:
        scores = np.zeros(100)
        scores[: int(100 * next(self.shares))] = 1.0
        return CampResult(scores, scores, scores.astype(np.int64))


def test_the_version_that_wins_most_is_kept(model: QMIX, tmp_path: Path) -> None:
    judge = Scorer("red", ["MA1", "MA2"], Terms(games=1), {"scenario": "plain"})
    judge.shares = iter((0.2, 0.3, 0.9, 0.3, 0.1, 0.1))
    hashes = []
    for seed in range(3):
        model.policy.targets[0].data.fill_(seed)
        hashes.append(model.policy.freeze_settled().sha256)
        judge.see(model)
    judge.save(tmp_path / "best")

    kept = FrozenPolicy.load(tmp_path / "best")
    assert (kept.sha256, judge.win_rate) == (hashes[1], 0.6)
    assert kept.about["side"] == "red"


def test_of_equal_versions_the_first_is_kept(model: QMIX) -> None:
    judge = Scorer("red", ["MA1"], Terms(games=1), {})
    judge.shares = iter((0.5, 0.5))
    judge.see(model)
    first = judge.best
    judge.see(model)

    assert judge.best is first


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_versions_play_in_their_own_camp(model: QMIX, camp: str) -> None:
    """MA1 wins every game against an untrained model, whoever is red."""
    judge = Judge(camp, ["MA1"], Terms(games=4), {})
    judge.see(model)

    assert judge.win_rate == 0.0
