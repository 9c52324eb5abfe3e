"""The search over the rivals' settings, counted by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import tyro

from hexwar_sb3.commands.rival_dqn import RivalDqn
from hexwar_sb3.commands.task_ppo import TaskPpo
from hexwar_sb3.experiments.rivals import HEADS, SETTINGS, cells, runs, summary
from hexwar_sb3.experiments.runs import RIVAL_DQN, Budget, Places, choose

RUNS = runs(Budget(games=100), (0,))


def test_every_setting_is_one_of_its_own_and_a_command_that_is_understood() -> None:
    assert len({run.command for run in RUNS}) == 2 * SETTINGS >= 40
    assert runs(Budget(games=100), (0,)) == RUNS
    for run in RUNS:
        cls = RivalDqn if run.module == RIVAL_DQN else TaskPpo
        assert tyro.cli(cls, args=run.arguments, config=(tyro.conf.FlagCreatePairsOff,)).games == 100


def test_the_best_of_a_rival_comes_first(places: Places, make_results: Callable[..., Path]) -> None:
    for margin, name in ((10.0, "dqn-00-0"), (30.0, "dqn-07-0"), (20.0, "ppo-01-0")):
        make_results(*choose(RUNS, [name]), margin=margin)

    rows = summary(RUNS, places)
    assert [row["run"] for row in rows] == ["dqn-07-0", "dqn-00-0", "ppo-01-0"]
    assert rows[0]["mean_margin"] - rows[1]["mean_margin"] == pytest.approx(20.0)
    assert rows[1]["settings"] == "the default"
    assert "stickiness" in rows[0]["settings"]
    assert all(len(line) == len(HEADS) for line in cells(rows))
