from __future__ import annotations

from collections.abc import Callable
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
    assert {path.relative_to(kept).as_posix() for path in kept.rglob("*")} == {
        *("page.json", "page.txt", "command.txt", "config.json", "curve.csv"),
        *("policy", "policy/weights.safetensors"),
    }
    assert (kept / "command.txt").read_text(encoding="utf-8") == RUN.command + "\n"
    assert len((kept / "curve.csv").read_text(encoding="utf-8").splitlines()) == 1 + 2 * 3


def test_a_run_of_the_ablation_keeps_its_figures_only(places: Places, make_folder: MakeFolder) -> None:
    run = ablation.runs(Budget(games=100), seeds=[0])[0]
    folder = make_folder(run)
    (folder / "policy").mkdir()

    keep(run, folder, places.kept(run))

    assert (places.kept(run) / "page.json").exists()
    assert not (places.kept(run) / "policy").exists()


def test_a_broken_run_folder_leaves_no_results(places: Places, make_folder: MakeFolder) -> None:
    folder = make_folder(RUN)
    (folder / "evaluations.npz").unlink()

    with pytest.raises(FileFormatError, match="evaluations"):
        keep(RUN, folder, places.kept(RUN))

    assert not places.is_kept(RUN)
