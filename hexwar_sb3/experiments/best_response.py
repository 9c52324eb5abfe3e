"""How exploitable a player is: fresh best responses are trained against it, frozen, and say how many games they need.

Only fresh opponents measure robustness: whoever was trained against known ones may fall to the next.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, cast

import numpy as np
import torch

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.callbacks.shares import shares_of
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.parcels import as_place, at_hand
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.evaluation.tournament import fingerprint
from hexwar_sb3.files import replacing
from hexwar_sb3.kinds import fits, read_fields
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.reading import read_json

HALF = 0.5  # win rate from which a response is said to have the better of the player


@dataclass(frozen=True, kw_only=True)
class Point:
    """How a response did against the player after some games of its training."""

    games: int
    win_rate: float  # with the ends of its 95 % interval
    win_rate_low: float
    win_rate_high: float
    mean_margin: float
    points_held: float  # mean number at the end


@dataclass(frozen=True, kw_only=True)
class Response:
    """A best response that is to be trained."""

    player: object  # whom it meets: a name or a folder
    camp: str  # that the response plays
    seed: int
    games: int = 4_000  # that it learns from
    every: int = 250  # games between two evaluations
    eval_games: int = 200
    scenario: ScenarioLike = "plain"

    def head(self) -> dict[str, Any]:
        """What its figures depend on; they stand beside them."""
        own = {name: value for name, value in vars(self).items() if name != "player"}
        return {"player": fingerprint(self.player), **own, **provenance(self.scenario)}

    def at_hand(self) -> Response:
        """The same with what lies in files named so that it travels."""
        return replace(self, player=as_place(self.player), scenario=at_hand(self.scenario))

    @property
    def evaluation(self) -> Evaluation:
        """How it is measured; both decide as often as the player was trained to."""
        return Evaluation(
            terms=replace(trained_terms(self.player), scenario=self.scenario),
            games=self.eval_games,
            seed=self.seed,
            purpose=Purpose.SELECTION,
            camps=(self.camp,),
        )


@dataclass(frozen=True)
class Job:
    """A response to train, what its figures depend on, and their file."""

    response: Response
    head: Mapping[str, Any]
    file: Path


def responses(responses: Sequence[Response], folder: Path, jobs: int = 1) -> list[dict[str, Any]]:
    """Train every response whose figures are not in the folder yet; the figures of all.

    Raises:
        FileFormatError: a file there is broken, or of another player or other settings.
    """
    jobs_of = [Job(one.at_hand(), one.head(), folder / f"{one.camp}_{one.seed}.json") for one in responses]
    for job in jobs_of:
        if job.file.exists():
            read_figures(job.file, job.head)
    missing = [job for job in jobs_of if not job.file.exists()]
    run_jobs(respond, missing, jobs, "response", leaves=lambda job: [job.file])
    return [read_figures(job.file, job.head) for job in jobs_of]


def respond(job: Job) -> None:
    """Train one response, and leave its figures: a function of `job` alone, in any process."""
    torch.set_num_threads(1)
    start = process_time()
    curve = train_response(job.response)
    figures = {"head": job.head, "cpu_seconds": round(process_time() - start, 1), "curve": curve}
    with replacing(job.file) as temporary:
        temporary.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def train_response(response: Response) -> list[dict[str, Any]]:
    """Train a response; its figures against the player at every evaluation."""
    how, preset = response.evaluation, PRESETS["default"]
    terms = how.terms.settings
    seed = seed_for(Purpose.TRAINING, response.seed)
    env = make_vec_env(
        TASK_ENV,
        seed=seed,
        side=response.camp,
        opponent=response.player,
        **{**preset.env_for(response.scenario), **terms},
    )
    learner = preset.learner_for(response.games, response.scenario)
    model = QMIX("TaskPolicy", env, seed=response.seed, **learner)
    decisions = how.terms.env_steps(1)
    watch = Watch(response.every * decisions, decisions, response.camp, response.player, how)
    model.learn(response.games * decisions, callback=[*shares_of(preset, response.games), watch])
    return watch.curve


class Watch(EverySteps):
    """Lets the response as it is play against the player, and notes how it went.

    Args:
        every: env steps between two evaluations.
        decisions: env steps of a game.
        camp: of the response.
        player: whom it meets.
        evaluation: how it is measured.
    """

    def __init__(self, every: int, decisions: int, camp: str, player: object, evaluation: Evaluation) -> None:
        super().__init__(every)
        self.decisions, self.camp, self.player, self.evaluation = decisions, camp, player, evaluation
        self.curve: list[dict[str, Any]] = []

    def fire(self) -> None:
        """Play, and note."""
        result = self.evaluation.play_as(self.camp, cast("QMIX", self.model).policy.freeze(), self.player)
        row = Point(
            games=self.now() // self.decisions,
            win_rate=result.win_rate.value,
            win_rate_low=result.win_rate.low,
            win_rate_high=result.win_rate.high,
            mean_margin=result.mean_margin.value,
            points_held=float(result.points_held.mean()),
        )
        self.curve.append(asdict(row))


def _is_same(found: object, head: Mapping[str, Any]) -> bool:
    """Whether figures depend on the same; another version of the program may go on."""
    return isinstance(found, dict) and {**found, "software": head["software"]} == head


def read_figures(file: Path, head: Mapping[str, Any]) -> dict[str, Any]:
    """Read what a response left.

    Raises:
        FileFormatError: it is broken, or of another player or other settings.
    """
    found = read_json(file, "a best response")
    if not _is_same(found.get("head"), head):
        expected = "the same player, settings and rules: choose another folder"
        raise FileFormatError(file, "head", found=str(found.get("head"))[:200], expected=expected)
    curve = found.get("curve")
    if not isinstance(curve, list) or not curve:
        raise FileFormatError(file, "curve", found=str(curve)[:80], expected="a list of evaluations")
    for n, row in enumerate(curve):
        read = Point(**read_fields(Point, row, file, place=f"curve[{n}]", whole=True))
        if read.games < 0 or not 0.0 <= read.win_rate <= 1.0:
            raise FileFormatError(file, f"curve[{n}]", found=str(read), expected="games, and a rate in 0..1")
    if not fits(found.get("cpu_seconds"), float):
        seconds = str(found.get("cpu_seconds"))[:80]
        raise FileFormatError(file, "cpu_seconds", found=seconds, expected="a number")
    return found


def games_until_half(figures: dict[str, Any]) -> int | None:
    """Games after which a response first won half of its games; None: it never did."""
    return next((int(row["games"]) for row in figures["curve"] if row["win_rate"] >= HALF), None)


def summary(found: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """By the response's camp: games until it wins half, of each seed and their median; its best win rates.

    A response that never did counts as more than all.
    """
    by_camp: dict[str, dict[str, Any]] = {}
    for camp in dict.fromkeys(str(figures["head"]["camp"]) for figures in found):
        own = [figures for figures in found if figures["head"]["camp"] == camp]
        needed = [games_until_half(figures) for figures in own]
        middle = median([np.inf if games is None else games for games in needed])
        by_camp[camp] = {
            "seeds": [figures["head"]["seed"] for figures in own],
            "games until half": needed,
            "median": None if np.isinf(middle) else middle,
            "best win rate": [max(row["win_rate"] for row in figures["curve"]) for figures in own],
            "last win rate": [figures["curve"][-1]["win_rate"] for figures in own],
            "last mean margin": [figures["curve"][-1]["mean_margin"] for figures in own],
        }
    return by_camp
