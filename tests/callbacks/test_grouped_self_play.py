"""A league as a callback: the model begins it, and is its champion in the end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sb3_contrib import MaskablePPO

from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.grouped_self_play import GroupedSelfPlayCallback
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.league.league import League
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.players.frozen_lower import FrozenLower, fastest_way_network

TINY = LeagueSettings(
    keep=1, iterations=1, games=2, fill_games=1, refit_games=1, match_games=1, warm_up_games=1, n_envs=2, split=True, opponents=("MA1",), hidden=64, embed=32,
    learner={"learning_starts": 0, "buffer_size": 100, "batch_size": 8},
)  # fmt: skip
SMALL: dict[str, Any] = {"learning_starts": 0, "buffer_size": 100, "batch_size": 8, "seed": 0}


def qmix(**settings: Any) -> QMIX:
    env = make_vec_env(n_envs=2, seed=1, privileged_state=True, **{"side": "both", **settings})
    return QMIX("TaskPolicy", env, **SMALL)


def test_the_model_ends_as_the_champion(tmp_path: Path) -> None:
    qmix().learn(1, callback=GroupedSelfPlayCallback(tmp_path, TINY))
    model, callback = qmix(), GroupedSelfPlayCallback(tmp_path, TINY)
    next(model.policy.agent.parameters()).data.fill_(0.0)  # no champion
    before = model.policy.freeze().sha256
    model.learn(1, callback=callback)

    assert model.policy.freeze().sha256 == callback.champions["red"].sha256 != before
    assert model.num_timesteps == League.open(tmp_path).env_steps == 2 * 2 * 24


def test_a_blue_model_ends_as_blues_champion(tmp_path: Path) -> None:
    other = tmp_path / "other"
    qmix().learn(1, callback=GroupedSelfPlayCallback(other, TINY))
    model = qmix(side="blue")
    callback = GroupedSelfPlayCallback(tmp_path / "league", TINY, starters={"other": other / "learner"})
    model.learn(1, callback=callback)

    assert model.policy.freeze().sha256 == callback.champions["blue"].sha256
    assert [member.name for member in League.open(tmp_path / "league").starters("red")] == ["other"]


def test_a_finished_league_is_not_played_again(tmp_path: Path) -> None:
    first, second = GroupedSelfPlayCallback(tmp_path, TINY), GroupedSelfPlayCallback(tmp_path, TINY)
    qmix().learn(1, callback=first)
    made = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.safetensors")}
    qmix().learn(1, callback=second)

    assert made == {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.safetensors")}
    assert first.champions["red"].sha256 == second.champions["red"].sha256


def test_a_larger_budget_learns_on_after_the_league(tmp_path: Path) -> None:
    model, callback = qmix(), GroupedSelfPlayCallback(tmp_path, TINY)
    model.learn(2 * 2 * 24 + 48, callback=callback)

    assert model.num_timesteps == 2 * 2 * 24 + 48
    assert model.policy.freeze().sha256 != callback.champions["red"].sha256


def test_both_levels_are_taken_over(tmp_path: Path) -> None:
    env = make_vec_env(n_envs=2, side="both", privileged_state=True, lower=fastest_way_network(), seed=0)
    model = HierarchicalQMIX("HierarchicalPolicy", env, phase_ticks=(1, 0), **SMALL)
    model.learn(1, callback=GroupedSelfPlayCallback(tmp_path / "league", TINY))
    model.save(tmp_path / "model")
    again = HierarchicalQMIX.load(tmp_path / "model")

    assert isinstance(model.policy.lower, FrozenLower)
    assert isinstance(again.policy.lower, FrozenLower)
    for name, weights in fastest_way_network().weights.items():
        np.testing.assert_array_equal(again.policy.lower.weights[name], weights)


@pytest.mark.parametrize(("side", "split"), [("both", False), ("red", True)])
def test_without_settings_the_league_is_the_models_own(
    side: str, split: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    callback = GroupedSelfPlayCallback(tmp_path)
    monkeypatch.setattr(callback, "_play", lambda *_: None)
    qmix(side=side).learn(1, callback=callback)

    assert (callback.settings.split, callback.settings.hidden, callback.settings.embed) == (split, 64, 32)


def test_another_map_or_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="the league plays plain, the model's env hills"):
        qmix(scenario="hills").learn(1, callback=GroupedSelfPlayCallback(tmp_path, TINY))
    with pytest.raises(
        ConfigError, match=r"the league's models have .*128.*, the model .*64.*: make them alike"
    ):
        qmix().learn(1, callback=GroupedSelfPlayCallback(tmp_path, replace(TINY, hidden=128)))
    ppo = MaskablePPO("MultiInputPolicy", make_vec_env(n_envs=2, seed=0), n_steps=24, batch_size=16)
    with pytest.raises(
        ConfigError, match="grouped self-play is for QMIX and HierarchicalQMIX, got MaskablePPO"
    ):
        ppo.learn(1, callback=GroupedSelfPlayCallback(tmp_path, TINY))
