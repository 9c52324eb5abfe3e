"""From a finished run folder to what is kept of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.opponents import named
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.experiments.curve import curve_rows
from hexwar_sb3.experiments.kept import Kept, Record
from hexwar_sb3.experiments.runs import Run
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.reading import read_json


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a run's settings say of its evaluations: those of `hexwar train`, or of a baseline."""

    opponents: tuple[str, ...] = BOTS
    scenario: str = "plain"
    decisions: str | None = None
    decision_ticks: int | None = None  # not said: they are not known


def keep(run: Run, folder: Path, kept: Kept) -> None:
    """Keep the results of a finished run folder.

    Raises:
        FileFormatError: a file of the folder is broken.
    """
    config = read_json(folder / "config.json", "a run's settings")
    record = Record(command=run.command, config=config, page=read_json(folder / "page.json", "a page"))
    policy = folder / "policy"
    kept.put(record, _curve_of(config, folder), policy if run.with_policy and policy.is_dir() else None)


def _curve_of(config: Mapping[str, Any], folder: Path) -> Iterator[dict[str, Any]]:
    own = {name: value for name, value in config.items() if name in Measured.__dataclass_fields__}
    said = Measured(**read_fields(Measured, own, folder / "config.json"))
    return curve_rows(
        History.load(folder / "evaluations.npz"),
        named(said.opponents),
        decision_ticks=None if said.decisions == "event" else said.decision_ticks,
        game_ticks=load_world(said.scenario).scenario.game_ticks,
    )
