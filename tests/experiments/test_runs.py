from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import pytest
import tyro

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.cli import parse
from hexwar_sb3.commands.baseline import Baseline
from hexwar_sb3.commands.flat_dqn import FlatDqn
from hexwar_sb3.commands.rival_dqn import RivalDqn
from hexwar_sb3.commands.task_ppo import TaskPpo
from hexwar_sb3.commands.train import Train
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.experiments import ablation, fig7
from hexwar_sb3.experiments.runs import (
    FLAT_DQN,
    HEXWAR,
    RIVAL_DQN,
    TASK_PPO,
    Budget,
    Places,
    Run,
    State,
    baseline_run,
    choose,
    hrl_run,
)

MakeFolder = Callable[..., Path]

BUDGET = Budget(games=100)
RUNS = {run.row: run for module in (fig7, ablation) for run in module.runs(BUDGET, [0])}
TRAINED = {row: run for row, run in RUNS.items() if run.module == HEXWAR}
DIFFERS = {
    "vdn": {"mixer"},
    "iql": {"mixer"},
    "warm-start": {"warm_start"},
    "no-demos": {"demo_share"},
    "one-step": {"n_steps"},
    "plain-epsilon": {"stickiness"},
    "only-ma1": {"opponents"},
    "gamma-1": {"gamma"},
    "paper-reward": {"reward"},
    "lambda-08": {"td_lambda"},
    "single-q": {"double_q"},
    "paper-preset": {"preset"},
    "learned-lower": {"lower"},
    "no-squads": {"squad_initial_share", "squad_final_share"},
    "seen-camp": {"mirrored"},
    "narrow": {"hidden"},
    "broad": {"opponents"},
    "broad-even": {"opponents", "priority"},
}
PLANS = {"constant_plans"}  # played once, by the base
RUN = hrl_run("fig7", "hrl-plain", 0, BUDGET)


def settings_of(run: Run) -> Train:
    settings = parse(run.arguments)
    assert isinstance(settings, Train)
    return settings


def settings_of_baseline(run: Run) -> Baseline:
    kinds: dict[str, type[Baseline]] = {FLAT_DQN: FlatDqn, RIVAL_DQN: RivalDqn, TASK_PPO: TaskPpo}
    return tyro.cli(kinds[run.module], args=run.arguments, config=(tyro.conf.FlagCreatePairsOff,))


@pytest.mark.parametrize("row", TRAINED)
def test_every_run_is_a_command_of_hexwar_train_with_the_same_games(row: str) -> None:
    settings = settings_of(TRAINED[row])

    assert settings.games == 100
    assert settings.n_timesteps == 10 * settings.eval_freq == 5 * settings.save_freq


@pytest.mark.parametrize("row", [row for row in RUNS if row not in TRAINED])
def test_every_baseline_is_a_command_of_its_module(row: str) -> None:
    settings = settings_of_baseline(RUNS[row])

    assert settings.games == 10 * settings.eval_freq + settings.games % 10
    assert settings.scenario == (row.partition("-")[2] if RUNS[row].experiment == "fig7" else "plain")


def test_the_baseline_of_the_figure_has_as_many_ticks_as_both_levels_together() -> None:
    """Of 18 million ticks of the upper level, the lower one's phases come after 4.5, 9 and 13.5 million."""
    upper, lower = PRESETS["default"].phase_ticks
    baselines = fig7.rivals("plain", 0, Budget(games=10_000))

    assert upper == 4_500_000
    games = {settings_of_baseline(run).games for run in baselines}
    assert games == {math.ceil(10_000 + 3 * lower / 1_800)}


@pytest.mark.parametrize("row", ablation.BASELINES)
def test_a_baseline_of_the_ablation_has_as_many_games_as_a_base_without_lower_level(row: str) -> None:
    settings = settings_of_baseline(RUNS[row])

    assert (settings.games, settings.constant_plans) == (100, False)


@pytest.mark.parametrize("row", DIFFERS)
def test_a_row_of_the_ablation_differs_from_the_base_as_it_says(row: str) -> None:
    ours, base = asdict(settings_of(RUNS[row])), asdict(settings_of(RUNS["base"]))

    assert {name for name in ours if ours[name] != base[name]} - PLANS == DIFFERS[row]


def test_the_ablation_has_every_row_that_was_tried() -> None:
    rows = [run.row for run in ablation.runs(BUDGET, [0])]

    assert sorted(rows) == sorted([*DIFFERS, "base", "flat-dqn", "maskable-ppo"])
    assert set(ablation.SAYS) == set(rows)


def test_the_figure_has_all_seeds_on_the_first_map_and_one_on_the_others() -> None:
    names = [run.name for run in fig7.runs(BUDGET, [0, 1, 2])]

    assert sorted(names) == sorted(
        f"{method}-{row}"
        for method in ("hrl", "rival", "dqn", "ppo")
        for row in ("plain-0", "plain-1", "plain-2", "hills-0", "paddy-0")
    )


def test_a_command_says_all_that_makes_the_run_again() -> None:
    assert RUN.command == (
        "hexwar train --scenario plain --seed 0 --n-timesteps 2400 --decision-ticks 75 --eval-freq 240 "
        "--save-freq 480 --eval-games 64 --final-games 2000"
    )
    assert baseline_run(FLAT_DQN, "fig7", "dqn-plain", 0, BUDGET).command.startswith(
        f"python -m {FLAT_DQN} --scenario plain"
    )


def test_a_run_is_missing_then_broken_off_then_done(places: Places, make_results: MakeFolder) -> None:
    states = [places.state(RUN)]
    folder = places.work / "fig7" / "hrl-plain-0_1"
    folder.mkdir(parents=True)
    (folder / "command.txt").write_text(f"{RUN.command} --runs x --name y", encoding="utf-8")
    states.append(places.state(RUN))
    (folder / "checkpoint.npz").touch()
    states.append(places.state(RUN))
    folder.rename(folder.with_name("hrl-plain-0_0"))
    make_results(RUN)
    states.append(places.state(RUN))

    assert states == [State.MISSING, State.MISSING, State.BROKEN_OFF, State.DONE]


def test_the_newest_folder_of_the_very_command_is_gone_on_with(places: Places) -> None:
    for k, command in ((2, RUN.command), (10, RUN.command), (11, RUN.command + "0")):
        folder = places.work / "fig7" / f"hrl-plain-0_{k}"
        folder.mkdir(parents=True)
        (folder / "command.txt").write_text(f"{command} --runs x --name y", encoding="utf-8")

    assert places.folder(RUN) == places.work / "fig7" / "hrl-plain-0_10"


def test_results_of_another_command_are_refused_with_both_commands(
    places: Places, make_results: MakeFolder
) -> None:
    make_results(RUN)
    other = hrl_run("fig7", "hrl-plain", 0, Budget(games=200))

    with pytest.raises(ConfigError, match=r"n-timesteps 2400 .*, not by .*n-timesteps 4800"):
        places.state(other)


def test_runs_are_chosen_by_row_or_by_name() -> None:
    runs = ablation.runs(BUDGET, [0, 1])

    assert [run.name for run in choose(runs, ["vdn", "iql-1"])] == ["vdn-0", "vdn-1", "iql-1"]
    assert choose(runs, []) == runs


def test_an_unknown_run_is_met_with_the_nearest_one() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown run 'vdn-7'; did you mean 'vdn-[01]'"):
        choose(ablation.runs(BUDGET, [0, 1]), ["vdn-7"])


def test_a_budget_of_nothing_is_refused() -> None:
    with pytest.raises(ConfigError, match="games must be at least 1, got 0"):
        Budget(games=0)
