"""Runs that another machine makes: programs of a few lines stand for the training."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hexwar_sb3.experiments.carry_out import carry_out
from hexwar_sb3.experiments.errand import Errand, go
from hexwar_sb3.experiments.runs import Budget, Places, Run, hrl_run

RUN = hrl_run("fig7", "hrl-plain", 0, Budget(games=100))
MAKES = """
import pathlib, sys
runs, name = (sys.argv[sys.argv.index(flag) + 1] for flag in ("--runs", "--name"))
folder = pathlib.Path(runs, name + "_1")
(folder / "policy").mkdir(parents=True)
for file in ("checkpoint.npz", "page.txt", "policy/config.json"):
    (folder / file).write_text(runs)
print("made it")
"""
FAILS = "import sys; print('no luck'); sys.exit(3)"


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Run]:
    """Make a run of a text that `python -m` finds."""

    def make(text: str) -> Run:
        (tmp_path / "errand_program.py").write_text(text, encoding="utf-8")
        return replace(RUN, module="errand_program")

    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return make


def test_its_settings_name_the_folder_that_the_user_named(
    program: Callable[[str], Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    errand = Errand.of(program(MAKES), Places(Path("results"), Path("runs/experiments")))

    assert go(errand) == 0
    assert (errand.folder / "page.txt").read_text(encoding="utf-8") == "runs/experiments/fig7"
    assert errand.folder == Path("runs/experiments/fig7/hrl-plain-0_1")


@pytest.mark.parametrize("work", ["/nowhere/runs", "../runs"])
def test_a_folder_that_is_elsewhere_is_said_by_its_name(work: str) -> None:
    assert Errand.of(RUN, Places(Path("results"), Path(work))).runs == "fig7"


@pytest.mark.usefixtures("elsewhere")
def test_a_run_comes_back_without_its_checkpoint(program: Callable[[str], Run], places: Places) -> None:
    """It is not whole: a training leaves more. So it counts as failed, and what is there can be looked at."""
    run = program(MAKES)
    said: list[str] = []

    carry_out([run], places, jobs=2, say=said.append)

    made = places.work / "fig7" / "hrl-plain-0_1"
    found = {path.relative_to(made).as_posix() for path in made.rglob("*") if path.is_file()}
    assert found == {"page.txt", "policy/config.json"}
    assert places.log(run).read_text(encoding="utf-8") == "made it\n"


@pytest.mark.usefixtures("elsewhere")
def test_a_run_that_fails_is_named_with_its_log(program: Callable[[str], Run], places: Places) -> None:
    run = program(FAILS)
    said: list[str] = []

    assert carry_out([run], places, say=said.append) == [run]
    assert said[-1] == f"hrl-plain-0: failed with exit code 3; see {places.log(run)}"
    assert places.log(run).read_text(encoding="utf-8") == "no luck\n"


def test_a_run_that_was_begun_keeps_its_folder(places: Places) -> None:
    (places.work / "fig7" / "hrl-plain-0_1").mkdir(parents=True)

    assert Errand.of(RUN, places).folder.name == "hrl-plain-0_2"
