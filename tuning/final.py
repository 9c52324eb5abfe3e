"""Finalists of a study: points of its trials and the paper's, on the same fresh games."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from optuna.trial import TrialState
from scipy.stats import t as student

from hexwar_sb3.algorithms.preset_file import load_preset
from hexwar_sb3.algorithms.presets import Preset
from hexwar_sb3.checks import check_whole
from hexwar_sb3.evaluation.intervals import CONFIDENCE, paired_interval
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.panel import Panel, play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.folders import holding
from hexwar_sb3.tuning.objective import Common, train_once
from hexwar_sb3.tuning.space import Point, first_point
from hexwar_sb3.tuning.study import StudySpec, begin, completed

PAPER = "paper"  # name of its point
Pair = tuple[CampResult, CampResult]  # of a point, of the paper's: the same games


@dataclass(frozen=True, kw_only=True)
class Finalist:
    """A point, trained with one seed."""

    common: Common
    preset: Preset  # with the point
    name: str
    seed: int
    policy: Path  # its folder

    @property
    def label(self) -> str:
        """Its name in tables."""
        return f"{self.name}, seed {self.seed}"


def compare(
    spec: StudySpec,
    games: int = 2_000,
    seeds: Sequence[int] = (),
    workers: int = 1,
    trials: Sequence[int] = (),
) -> dict[str, Any]:
    """Let points of a study and the paper's play the panel, game by game on the same seeds; the games are fresh ones.

    Args:
        spec: the study.
        games: a policy, opponent and colour.
        seeds: of the trainings; else as many as a trial has, fresh ones: the study chose its points by its own. What the
            study did not make is made, by its own budget.
        workers: trainings, and then finalists, side by side.
        trials: by number, whose points they are; else that of the best.

    Returns:
        Points, seeds, rows of all, and for each trial the paired differences from the paper's point, of margin (points)
        and win rate (percent): for each seed and of all games, with the interval of the games; and, as trainings of one
        point differ by more than games tell, with the interval of the trainings.

    Raises:
        ConfigError: a trial was not completed, or a number is out of its range.
        BusyError: another process trains for a comparison of this study.
    """
    check_whole("games", games, least=1)
    seeds = tuple(dict.fromkeys(seeds or spec.common.fresh_seeds))
    for seed in seeds:
        seed_for(Purpose.REPORT, seed)
    points = {f"trial {one.number}": dict(one.params) for one in completed(begin(spec), trials)}
    points[PAPER] = first_point(load_preset(spec.preset), spec.space)
    finalists = {(name, seed): _finalist(spec, name, points[name], seed) for seed in seeds for name in points}
    # By folder, since points may be equal.
    missing = {one.policy: one for one in finalists.values() if not one.policy.is_dir()}
    if missing:
        with holding(spec.folder / "finalists", "comparison"):
            run_jobs(_train, list(missing.values()), workers, "training", leaves=lambda one: [one.policy])
    played = run_jobs(partial(_play, games=games), list(finalists.values()), workers, "finalist")
    panels = dict(zip(finalists, played, strict=True))
    return {
        "points": points,
        "seeds": {"compared": list(seeds), "study": list(spec.common.seeds)},
        "rows": [row for panel in played for row in panel.summary()],
        "minus_paper": {
            name: _differences(
                {seed: (panels[name, seed].total, panels[PAPER, seed].total) for seed in seeds}
            )
            for name in points
            if name != PAPER
        },
    }


def _finalist(spec: StudySpec, name: str, point: Point, seed: int) -> Finalist:
    """The study's own policy of a point, where a completed trial made one with this seed."""
    policy = spec.folder / "finalists" / f"{'-'.join(map(_text, point.values()))}-seed{seed}"
    for trial in begin(spec).get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        own = spec.policies(trial.number) / str(seed)
        if seed in spec.common.seeds and trial.params == point and own.is_dir():
            policy = own
            break
    preset = load_preset(spec.preset).changed(point)
    return Finalist(common=spec.common, preset=preset, name=name, seed=seed, policy=policy)


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _train(one: Finalist) -> None:
    new = one.policy.with_name(f"{one.policy.name}.new")  # no name that the start of a study clears
    shutil.rmtree(new, ignore_errors=True)
    train_once(one.preset, one.common, one.seed, new)
    new.rename(one.policy)


def _play(one: Finalist, games: int) -> Panel:
    how = replace(one.common.evaluation(one.preset, games, one.seed), purpose=Purpose.REPORT)
    return play_panel(one.policy, one.common.panel, how, name=one.label)


def _differences(pairs: Mapping[int, Pair]) -> dict[str, Any]:
    """Of each seed, of all games, and of the trainings."""
    by_seed = {f"seed {seed}": _difference([pair]) for seed, pair in pairs.items()}
    found = {**by_seed, "all": _difference(pairs.values())}
    if len(by_seed) > 1:
        found["trainings"] = {
            measure: _of_trainings([one[measure]["value"] for one in by_seed.values()])
            for measure in found["all"]
        }
    return found


def _of_trainings(differences: Sequence[float]) -> dict[str, Any]:
    """Mean of a difference for each seed, with Student's interval: of further trainings, not only further games."""
    mean = float(np.mean(differences))
    error = float(np.std(differences, ddof=1)) / sqrt(len(differences))
    half = float(student.ppf((1 + CONFIDENCE) / 2, len(differences) - 1)) * error
    return {"value": mean, "interval": [mean - half, mean + half]}


def _difference(pairs: Iterable[Pair]) -> dict[str, Any]:
    """A point minus the paper's, with the paired interval."""
    own, paper = zip(*pairs, strict=True)

    def estimate(values: Callable[[CampResult], NDArray[np.float64]]) -> dict[str, Any]:
        one = paired_interval(np.concatenate([*map(values, own)]), np.concatenate([*map(values, paper)]))
        return {"value": one.value, "interval": [one.low, one.high]}

    return {
        "margin": estimate(lambda result: result.margins),
        "win_rate": estimate(lambda result: 100 * result.scores),
    }
