"""What is kept of a run: its small files, and its learning curve as a table."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.opponents import named
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.curve import curve_rows, write_curve
from hexwar_sb3.experiments.runs import Run
from hexwar_sb3.folders import making
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.reading import read_json

FILES = ("page.txt", "page.json", "config.json")


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a run's settings say of its evaluations: those of `hexwar train`, or of a baseline."""

    opponents: tuple[str, ...] = BOTS
    scenario: str = "plain"
    decisions: str | None = None
    decision_ticks: int | None = None  # not said: they are not known


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
    config = read_json(folder / "config.json", "a run's settings")
    own = {name: value for name, value in config.items() if name in Measured.__dataclass_fields__}
    said = Measured(**read_fields(Measured, own, folder / "config.json"))
    return curve_rows(
        History.load(folder / "evaluations.npz"),
        named(said.opponents),
        decision_ticks=None if said.decisions == "event" else said.decision_ticks,
        game_ticks=load_world(said.scenario).scenario.game_ticks,
    )
