"""What is kept of a run: its small files, and its learning curve as a table."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.experiments.curve import curve_rows, write_curve
from hexwar_sb3.experiments.runs import Run

FILES = ("page.txt", "config.json")


def keep(run: Run, folder: Path, kept: Path) -> None:
    """Copy the results of a finished run folder, whole or not at all."""
    new = kept.with_name(f".new-{kept.name}")
    shutil.rmtree(new, ignore_errors=True)
    new.mkdir(parents=True)
    for name in FILES:
        shutil.copyfile(folder / name, new / name)
    if (folder / "policy").is_dir():
        shutil.copytree(folder / "policy", new / "policy")
    (new / "command.txt").write_text(run.command + "\n", encoding="utf-8")
    (new / "page.json").write_text(json.dumps(page_of(folder), indent=2) + "\n", encoding="utf-8")
    write_curve(new / "curve.csv", _curve_of(folder))
    new.rename(kept)


def page_of(folder: Path) -> dict[str, object]:
    """Figures of the page; its minutes are those of all parts, where the run was broken off and gone on with."""
    page: dict[str, object] = json.loads((folder / "page.json").read_text(encoding="utf-8"))
    parts = sorted(folder.glob("progress*.csv"))
    if len(parts) > 1:
        page["minutes"] = sum(_seconds(part) for part in parts) / 60
    return page


def _seconds(progress: Path) -> float:
    """Wall time of a part of a training by its log."""
    with progress.open(encoding="utf-8", newline="") as file:
        times = [float(row.get("time/time_elapsed") or 0.0) for row in csv.DictReader(file)]
    return max(times, default=0.0)


def _curve_of(folder: Path) -> Iterator[dict[str, Any]]:
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    varies = config.get("decisions") == "event"
    return curve_rows(
        History.load(folder / "evaluations.npz"),
        config["opponents"],
        decision_ticks=None if varies else config["decision_ticks"],
        game_ticks=load_world(config["scenario"]).scenario.game_ticks,
    )
