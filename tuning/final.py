"""Finalists of a study: its best point and the paper's, on the same fresh games."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from optuna.trial import FixedTrial, TrialState

from hexwar_sb3.algorithms.preset_file import load_preset
from hexwar_sb3.checks import check_whole
from hexwar_sb3.evaluation.intervals import paired_interval
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.panel import Panel, play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.tuning.objective import objective
from hexwar_sb3.tuning.space import Point, first_point
from hexwar_sb3.tuning.study import StudySpec, begin, best_trial

Pair = tuple[CampResult, CampResult]  # of the best point, of the paper's: the same games


@dataclass(frozen=True, kw_only=True)
class Finalist:
    """A point, trained with one seed."""

    spec: StudySpec
    name: str
    point: Point
    seed: int
    policy: Path  # its folder

    @property
    def number(self) -> str:
        """In what is printed."""
        return f"{self.name} {self.seed}"


def compare(
    spec: StudySpec, games: int = 2_000, seeds: Sequence[int] = (0,), workers: int = 1
) -> dict[str, Any]:
    """Let the best point and the paper's play the panel, game by game on the same seeds, fresh ones.

    Args:
        spec: the study.
        games: a policy, opponent and colour.
        seeds: of the trainings; one that the study did not make is made, by its own budget. Trainings of one point
            differ by more than games tell: the intervals are those of the games.
        workers: trainings, and then finalists, side by side.

    Returns:
        Points, rows of both, and the paired differences of margin (points) and win rate (percent), for each seed and of
        all games.

    Raises:
        ConfigError: no trial was completed, or a number is out of its range.
    """
    check_whole("games", games, least=1)
    best, seeds = best_trial(begin(spec)), tuple(dict.fromkeys(seeds))
    points = {"best": dict(best.params), "paper": first_point(load_preset(spec.preset), spec.space)}
    finalists = [_finalist(spec, name, points[name], seed) for seed in seeds for name in points]
    missing = {
        one.policy: one for one in finalists if not one.policy.is_dir()
    }  # once, if best and paper are one
    run_jobs(_train, list(missing.values()), workers, "training")
    played = run_jobs(partial(_play, games=games), finalists, workers, "finalist")
    panels = {one.number: panel for one, panel in zip(finalists, played, strict=True)}
    pairs = {seed: (panels[f"best {seed}"].total, panels[f"paper {seed}"].total) for seed in seeds}
    return {
        "points": points,
        "trial": best.number,
        "rows": [row for panel in panels.values() for row in panel.summary()],
        "best_minus_paper": {
            **{f"seed {seed}": _difference([pair]) for seed, pair in pairs.items()},
            "all": _difference(pairs.values()),
        },
    }


def _finalist(spec: StudySpec, name: str, point: Point, seed: int) -> Finalist:
    """The study's own policy of a point, where it made one with this seed."""
    policy = spec.folder / "finalists" / f"{'-'.join(map(_text, point.values()))}-seed{seed}"
    for trial in begin(spec).get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        own = spec.trial(trial.number) / "policy"
        if seed == spec.common.seed and trial.params == point and own.is_dir():
            policy = own
            break
    return Finalist(spec=spec, name=name, point=point, seed=seed, policy=policy)


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _train(one: Finalist) -> None:
    new = one.policy.with_name(f"{one.policy.name}.new")
    preset = load_preset(one.spec.preset).changed(one.point)
    objective(FixedTrial(one.point), preset, replace(one.spec.common, seed=one.seed), new)
    new.replace(one.policy)


def _play(one: Finalist, games: int) -> Panel:
    common = replace(one.spec.common, seed=one.seed)
    preset = load_preset(one.spec.preset).changed(one.point)
    terms = replace(common.terms(preset, games), purpose=Purpose.REPORT)
    return play_panel(str(one.policy), common.panel, terms, name=one.number)


def _difference(pairs: Iterable[Pair]) -> Mapping[str, Any]:
    """Best minus paper, with the paired interval."""
    best, paper = zip(*pairs, strict=True)

    def estimate(values: Callable[[CampResult], NDArray[np.float64]]) -> dict[str, Any]:
        one = paired_interval(np.concatenate([*map(values, best)]), np.concatenate([*map(values, paper)]))
        return {"value": one.value, "interval": [one.low, one.high]}

    return {
        "margin": estimate(lambda result: result.margins),
        "win_rate": estimate(lambda result: 100 * result.scores),
    }
