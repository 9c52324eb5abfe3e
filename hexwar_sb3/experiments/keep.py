"""What is kept of a run: its small files, and its learning curve as a table."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.experiments.curve import curve_rows, write_curve
from hexwar_sb3.experiments.runs import Run
from hexwar_sb3.folders import making

FILES = ("page.txt", "page.json", "config.json")


def keep(run: Run, folder: Path, kept: Path) -> None:
    """Copy the results of a finished run folder, whole or not at all."""
    with making(kept) as new:
        for name in FILES:
            shutil.copyfile(folder / name, new / name)
        if run.with_policy and (folder / "policy").is_dir():
            shutil.copytree(folder / "policy", new / "policy")
        (new / "command.txt").write_text(run.command + "\n", encoding="utf-8")
        write_curve(new / "curve.csv", _curve_of(folder))


def _curve_of(folder: Path) -> Iterator[dict[str, Any]]:
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    varies = config.get("decisions") == "event"
    return curve_rows(
        History.load(folder / "evaluations.npz"),
        config["opponents"],
        decision_ticks=None if varies else config["decision_ticks"],
        game_ticks=load_world(config["scenario"]).scenario.game_ticks,
    )
