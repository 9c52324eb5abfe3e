"""Run folders and results, made without training."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.experiments.keep import keep
from hexwar_sb3.experiments.kept import Kept
from hexwar_sb3.experiments.runs import Places, Run

MakeFolder = Callable[..., Path]


def page_rows(
    win_rate: float, margin: float, opponents: Sequence[str] = ("MA1", "MA2")
) -> list[dict[str, Any]]:
    """The trained player as on a page: blue as given, red 0.2 and 20 points more; two points in every other game."""
    return [
        {
            "player": "trained",
            "opponent": opponent,
            "camp": camp,
            "win_rate": win_rate + 0.2 * (camp == "red"),
            "mean_margin": margin + 20 * (camp == "red"),
            "points_held": [0.5, 0.0, 0.5],
        }
        for opponent in opponents
        for camp in ("red", "blue")
    ]


@pytest.fixture
def places(tmp_path: Path) -> Places:
    """Empty places."""
    return Places(tmp_path / "results", tmp_path / "work")


@pytest.fixture
def make_folder(places: Places) -> MakeFolder:
    """Make a finished run folder of a run: two evaluations of four games against MA1 and four against MA2."""

    def make(run: Run, *, win_rate: float = 0.5, margin: float = 0.0, minutes: float = 3.0) -> Path:
        folder = places.work / run.experiment / f"{run.name}_1"
        folder.mkdir(parents=True)
        config = {"scenario": "plain", "opponents": ["MA1", "MA2"], "decision_ticks": 75}
        others = page_rows(win_rate / 2, margin, ("nearest", "drawn-unseen"))
        page = {"minutes": minutes, "rows": page_rows(win_rate, margin), "others": others}
        texts = {"config.json": json.dumps(config), "page.json": json.dumps(page), "page.txt": "page\n"}
        texts["command.txt"] = f"{run.command} --runs x --name {run.name}\n"
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        scores = np.array([1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 1.0, 0.0])
        result = CampResult(scores, margin + np.arange(8.0), np.array([2, 2, 2, 1, 0, 0, 1, 0]))
        History([0, 2400], [0, 180_000], [result, result]).save(folder / "evaluations.npz")
        return folder

    return make


@pytest.fixture
def make_results(places: Places, make_folder: MakeFolder) -> Callable[..., Kept]:
    """Make the kept results of a run."""

    def make(run: Run, **figures: float) -> Kept:
        keep(run, make_folder(run, **figures), places.kept(run))
        return places.kept(run)

    return make
