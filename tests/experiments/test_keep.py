from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.experiments import ablation
from hexwar_sb3.experiments.keep import keep
from hexwar_sb3.experiments.runs import Budget, Places, hrl_run

MakeFolder = Callable[..., Path]
RUN = hrl_run("fig7", "hrl-plain", 0, Budget(games=100))


def test_small_results_are_kept_and_the_rest_is_left(places: Places, make_folder: MakeFolder) -> None:
    folder = make_folder(RUN)
    (folder / "model.zip").touch()
    (folder / "policy").mkdir()
    (folder / "policy" / "weights.safetensors").touch()

    keep(RUN, folder, places.kept(RUN))

    kept = places.kept(RUN)
    assert {path.relative_to(kept.folder).as_posix() for path in kept.folder.rglob("*")} == {
        *("runs.json", "curves.csv", "policies", "policies/hrl-plain-0"),
        "policies/hrl-plain-0/weights.safetensors",
    }
    assert kept.command == RUN.command
    assert len((kept.folder / "curves.csv").read_text(encoding="utf-8").splitlines()) == 1 + 2 * 3


def test_runs_of_an_experiment_share_two_files(places: Places, make_folder: MakeFolder) -> None:
    runs = [replace(RUN, seed=seed) for seed in (1, 0)]
    for run in (*runs, RUN):  # the last one again: what was kept of it is replaced
        if not places.kept(run).is_there:
            make_folder(run, margin=10.0 * run.seed)
        keep(run, places.work / "fig7" / f"{run.name}_1", places.kept(run))

    lines = (places.results / "fig7" / "runs.json").read_text(encoding="utf-8").splitlines()
    assert [line.partition(":")[0] for line in lines[1:-1]] == ['"hrl-plain-0"', '"hrl-plain-1"']
    curves = (places.results / "fig7" / "curves.csv").read_text(encoding="utf-8").splitlines()
    assert len(curves) == 1 + 2 * 2 * 3
    assert [places.kept(run).curve("MA1")["mean_margin"][0] for run in runs] == [11.5, 1.5]


def test_a_run_of_the_ablation_keeps_its_figures_only(places: Places, make_folder: MakeFolder) -> None:
    run = ablation.runs(Budget(games=100), seeds=[0])[0]
    folder = make_folder(run)
    (folder / "policy").mkdir()

    keep(run, folder, places.kept(run))

    assert places.kept(run).is_there
    assert not places.kept(run).policy.exists()


def test_a_broken_run_folder_leaves_no_results(places: Places, make_folder: MakeFolder) -> None:
    folder = make_folder(RUN)
    (folder / "evaluations.npz").unlink()

    with pytest.raises(FileFormatError, match="evaluations"):
        keep(RUN, folder, places.kept(RUN))

    assert not places.is_kept(RUN)
