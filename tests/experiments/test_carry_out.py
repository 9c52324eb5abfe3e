"""Runs as processes: programs of a few lines stand for the training."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import sleep

import pytest

from hexwar_sb3.experiments import carry_out as module
from hexwar_sb3.experiments.carry_out import arguments, carry_out
from hexwar_sb3.experiments.runs import FLAT_DQN, Budget, Places, Run, State, baseline_run, hrl_run

MakeFolder = Callable[..., Path]
RUN = hrl_run("fig7", "hrl-plain", 0, Budget(games=100))
BASELINE = baseline_run(FLAT_DQN, "fig7", "dqn-plain", 0, Budget(games=100))

WAITS = """
import pathlib, signal, sys, time
here = pathlib.Path(sys.argv[sys.argv.index("--runs") + 1])
def save(number, frame):
    with (here / "saved").open("a") as file:
        file.write("saved\\n")
    sys.exit(130)
signal.signal(signal.SIGTERM, save)
(here / "started").touch()
time.sleep(60)
"""
FAILS = "import sys; print('no luck'); sys.exit(3)"


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Make a module of a text that `python -m` finds; its name."""

    def make(text: str) -> str:
        name = f"program_{len(list(tmp_path.glob('*.py')))}"
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        return name

    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return make


def broken_off(run: Run, places: Places) -> Path:
    folder = places.work / run.experiment / f"{run.name}_1"
    folder.mkdir(parents=True)
    (folder / "command.txt").write_text(f"{run.command} --runs x --name y", encoding="utf-8")
    (folder / "checkpoint.npz").touch()
    return folder


def quietly(text: str) -> None:
    assert text


def no_start(*arguments: object) -> None:
    raise AssertionError(arguments)


def test_a_run_whose_results_are_there_is_not_started(
    places: Places, make_results: MakeFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_results(RUN)
    monkeypatch.setattr(module, "start", no_start)

    assert carry_out([RUN], places) == []


def test_a_run_folder_that_is_complete_is_kept_without_training(
    places: Places, make_folder: MakeFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stopped after the page and before the results: nothing is trained or played again."""
    make_folder(RUN)
    monkeypatch.setattr(module, "start", no_start)

    assert carry_out([RUN], places, say=quietly) == []
    assert places.state(RUN) == State.DONE


def test_a_run_that_was_broken_off_is_resumed(places: Places) -> None:
    folder = broken_off(RUN, places)

    assert arguments(RUN, places) == ["train", "--resume", str(folder)]


def test_a_run_of_another_command_is_not_resumed(places: Places) -> None:
    broken_off(RUN, places)
    other = hrl_run("fig7", "hrl-plain", 0, Budget(games=200))

    where = ["--runs", str(places.work / "fig7"), "--name", "hrl-plain-0"]
    assert arguments(other, places) == [*other.arguments, *where]


def test_a_baseline_starts_anew(places: Places) -> None:
    broken_off(BASELINE, places)

    assert arguments(BASELINE, places)[:2] == ["--scenario", "plain"]


def test_a_failed_run_is_named_with_its_log_and_the_others_go_on(
    places: Places, program: Callable[[str], str]
) -> None:
    said: list[str] = []
    runs = [replace(RUN, seed=seed, module=program(FAILS)) for seed in (0, 1)]

    failed = carry_out(runs, places, say=said.append)

    assert failed == runs
    assert said[-1] == f"hrl-plain-1: failed with exit code 3; see {places.log(runs[1])}"
    assert places.log(runs[0]).read_text(encoding="utf-8") == "no luck\n"


def test_ctrl_c_reaches_each_running_run_once_and_waits_until_it_has_saved(
    places: Places, program: Callable[[str], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run, here = replace(RUN, module=program(WAITS)), places.work / "fig7"

    def press(seconds: float) -> None:
        sleep(seconds)
        if (here / "started").exists():
            raise KeyboardInterrupt

    monkeypatch.setattr(module, "sleep", press)

    with pytest.raises(KeyboardInterrupt):
        carry_out([run], places, say=quietly)

    assert (here / "saved").read_text(encoding="utf-8") == "saved\n"


def test_no_more_runs_than_jobs_run_side_by_side(
    places: Places, make_folder: MakeFolder, program: Callable[[str], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = [replace(RUN, seed=seed, module=program("")) for seed in range(3)]
    started: list[Run] = []
    start = module.start

    def count(run: Run, places: Places, *, alone: bool) -> object:
        assert not alone
        started.append(run)
        kept = sum(places.is_kept(other) for other in started)
        assert len(started) - kept <= 2
        process = start(run, places, alone=alone)
        make_folder(run)
        return process

    monkeypatch.setattr(module, "start", count)

    assert carry_out(runs, places, jobs=2, say=quietly) == []
    assert all(places.is_kept(run) for run in runs)
