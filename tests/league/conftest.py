"""Small models to begin a league with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import as_member
from hexwar_sb3.league.settings import LeagueSettings

TINY: dict[str, Any] = {
    "keep": 2,
    "iterations": 2,
    "games": 4,
    "fill_games": 1,
    "refit_games": 1,
    "opponents": ("MA1", "drawn=2"),
    "match_games": 2,
    "warm_up_games": 2,
    "n_envs": 2,
    "hidden": 64,
    "embed": 32,
    "learner": {"learning_starts": 0, "buffer_size": 200, "batch_size": 8, "learning_rate": 1e-3},
}
"""A league of seconds."""


@pytest.fixture(scope="session")
def starters(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Two untrained models."""
    folder = tmp_path_factory.mktemp("starters")
    env = make_vec_env(n_envs=1, privileged_state=True, seed=0)
    for seed, name in enumerate(("one", "two")):
        model = QMIX("TaskPolicy", env, seed=seed, buffer_size=10)
        as_member(model, side="both", scenario="plain").save(folder / name)
    return {"one": folder / "one", "two": folder / "two"}


@pytest.fixture
def tiny() -> LeagueSettings:
    return LeagueSettings(**TINY)


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory, starters: dict[str, Path]) -> League:
    """A league that was never broken off."""
    league = League.create(tmp_path_factory.mktemp("whole"), LeagueSettings(**TINY), starters)
    league.run()
    return league


@pytest.fixture(scope="session")
def split(tmp_path_factory: pytest.TempPathFactory, starters: dict[str, Path]) -> League:
    """A league with models of each camp, as in the paper."""
    league = League.create(
        tmp_path_factory.mktemp("split"), LeagueSettings(**{**TINY, "split": True}), starters
    )
    league.run()
    return league
