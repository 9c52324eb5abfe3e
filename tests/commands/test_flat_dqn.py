"""The flat DQN, small: it stops after its games and leaves the files that a figure needs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stable_baselines3 import DQN

from hexwar_sb3.commands.baseline import finished_games
from hexwar_sb3.commands.flat_dqn import FlatDqn
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS

SMALL = FlatDqn(
    games=4, n_envs=2, buffer_size=1000, learning_games=1, eval_freq=2, eval_games=1, final_games=1
)


def test_a_training_ends_after_its_games_and_is_evaluated_at_them(tmp_path: Path) -> None:
    model, folder = SMALL.new_model(), RunFolder(tmp_path)

    SMALL.learn(model, folder)

    history = History.load(tmp_path / "evaluations.npz")
    assert finished_games(model) in {4, 5}
    assert history.timesteps[0] == 0
    assert [steps // 24 // 2 for steps in history.timesteps] == [0, 1, 2]
    assert DQN.load(tmp_path / "best_model.zip").num_timesteps >= 0


def test_its_page_has_the_rows_of_a_page_of_hexwar_train(tmp_path: Path) -> None:
    settings = replace(SMALL, runs=tmp_path, games=1)

    assert settings.run() == 0

    page = json.loads((tmp_path / "flat_dqn_1" / "page.json").read_text(encoding="utf-8"))
    cells = {(row["player"], row["opponent"], row["camp"]) for row in page["rows"]}
    assert cells == {
        (player, opponent, camp)
        for player in ("untrained", "trained", *CONSTANT_PLANS)
        for opponent in ("MA1", "MA2")
        for camp in ("red", "blue")
    }
    assert {"command", "seed", "rules", "scenario", "bots", "minutes"} <= set(page)


def test_a_turn_discounts_so_that_a_decision_has_its_gamma() -> None:
    assert SMALL.new_model().gamma ** SMALL.pieces == pytest.approx(0.99)


def test_rewards_are_scaled_and_episodes_are_recorded_in_points() -> None:
    env = SMALL.make_env()
    env.reset()
    scaled, recorded = 0.0, None
    while recorded is None:
        _, rewards, _, infos = env.step(np.array([3, 3]))
        scaled += float(rewards[0])
        recorded = infos[0].get("episode")

    assert 50 * scaled == pytest.approx(recorded["r"], abs=1e-3)
    assert recorded["r"] != 0
