"""Table I: warm-ups, grouped self-play and distillation in one pipeline, and who beats whom at its end (IV-A).

Stages leave files and are skipped where these are: warm-ups (those of figure 7, which make HRL0, and those of the table
of seeds, with which the league begins), league, CAI, matches.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import fmean
from typing import Any

from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.opponents import broad_mixture
from hexwar_sb3.evaluation.panel import BOTS, CONSTANT_PLANS
from hexwar_sb3.evaluation.tournament import Meeting, Table, pack, play_meetings, unpack
from hexwar_sb3.experiments.carry_out import carry_out
from hexwar_sb3.experiments.fig7 import hierarchy
from hexwar_sb3.experiments.runs import Budget, Places, Run
from hexwar_sb3.experiments.seeds import TRAINED, default_run
from hexwar_sb3.folders import holding, making
from hexwar_sb3.league.cai import DISTILLED, LEARNED, CaiSpec, make_cai
from hexwar_sb3.league.cost import Cost, added, measured, read_cost
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import BOTH, CAMPS, NETWORKS
from hexwar_sb3.league.picture import draw_league
from hexwar_sb3.league.selection import select
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.reading import read_json

NAME = "table1"
ROWS = ("HRL0", "HRL1", "HRL2", "CAI")
BROAD = "broad warm-up"  # row of the best warm-up of equal budget against the broad mixture
FURTHER = (BROAD, DISTILLED)  # rows beside the paper's
PLAYERS = ("nearest", "defender", "all-main", "half-half", "two-hold", "drawn-unseen")
"""Columns beside the paper's; nothing was trained or selected against the last two."""
PROGRESS = (*BOTS, "two-hold", "drawn-unseen")  # against whom the best of each iteration is measured
COLUMNS = (*BOTS, "HRL0", "HRL1", *PLAYERS)
WARM_UPS = 10_000  # games
CAI_LEARNER = {"learning_rate": 5e-4, "exploration_initial_eps": 0.1, "squad_initial_share": 0.3}
Say = Callable[[str], object]


@dataclass(frozen=True, kw_only=True)
class Table1:
    """The pipeline and its places."""

    places: Places
    seeds: tuple[int, ...] = (0, 1, 2, 3)  # of the warm-ups
    settings: LeagueSettings = field(default_factory=lambda: LeagueSettings(opponents=broad_mixture("plain")))
    lessons: Lessons = field(default_factory=lambda: Lessons(games=800, updates=4_000))
    cai_games: int = 35_000  # that a student learns from after it was distilled
    # of models for both camps so many learn on, and the best is CAI; where camps are split, one of each colour does
    students: int = 2
    # of CAI, where they differ from the league's: a longer training may change more
    cai_learner: Mapping[str, Any] = field(default_factory=lambda: dict(CAI_LEARNER))
    games: int = 2_000  # a cell
    progress_games: int = 400  # a colour and opponent, for each point of the league's picture
    jobs: int = 1  # side by side

    @property
    def kept(self) -> Path:
        """Small files that are committed."""
        return self.places.results / NAME

    @property
    def work(self) -> Path:
        """The league and CAI as they are made."""
        return self.places.work / NAME

    def warm_ups(self) -> list[Run]:
        """The paper's: trainings against MA1 and MA2."""
        return [hierarchy(self.settings.scenario, seed, Budget(games=WARM_UPS)) for seed in self.seeds]

    def starters(self) -> list[Run]:
        """What the league begins with: trainings of the same budget against the broad mixture."""
        return [default_run(self.settings.scenario, seed, Budget(games=WARM_UPS)) for seed in self.seeds]

    def best_warm_up(self) -> Path:
        """Policy of HRL0: the warm-up that wins most against MA1 and MA2."""
        kept = [self.places.kept(run) for run in self.warm_ups()]
        return max(kept, key=lambda one: fmean(r.win_rate for r in one.rows() if r.player == TRAINED)).policy

    @property
    def sides(self) -> tuple[str, ...]:
        """Whom a model plays: each camp has its own, or one plays both."""
        return CAMPS if self.settings.split else (BOTH,)

    def run(self, say: Say) -> Table | None:
        """Make what is missing; None if a warm-up failed.

        Raises:
            BusyError: another process works on it.
        """
        with ExitStack() as held:
            for folder in (self.work, self.kept):
                held.enter_context(holding(folder, "table"))
            return self._run(say)

    def _run(self, say: Say) -> Table | None:
        if carry_out([*self.warm_ups(), *self.starters()], self.places, jobs=self.jobs, say=say):
            return None
        league = self.league()
        league.run(self.jobs, after=lambda k: self._after(league, k, say))
        say("CAI: distillation, and learning on")
        missing = [spec for spec in self.combined(league) if not self.policy("CAI", spec.side).is_dir()]
        if missing:
            with measured(self.kept, "CAI"):
                run_jobs(make_cai, missing, self.jobs, "CAI", leaves=lambda spec: [spec.folder])
                self._keep_policies(league)
        if not (self.kept / "league.png").exists():
            say("matches of the best of each iteration")
            with measured(self.kept, "progress"):
                draw_league(league, self.progress(league), self.kept / "league.png")
        league.keep(self.kept / "league", models=False)
        say("matches of the table")
        return self.measure()

    def states(self) -> dict[str, str]:
        """How far each stage is."""
        league, combined = self.kept / "league", [self.policy("CAI", side).is_dir() for side in self.sides]
        done = [k for k in range(self.settings.iterations + 1) if (league / f"iteration_{k:02d}").is_dir()]
        played = len(read_json(self.matches) if self.matches.exists() else [])
        return {
            **{f"warm-up {run.name}": self.places.state(run) for run in (*self.warm_ups(), *self.starters())},
            "iterations of the league": f"{max(done, default=0)} of {self.settings.iterations}",
            "CAI": f"{sum(combined)} of {len(combined)}",
            "matches": f"{played} of {len(self.meetings())}",
        }

    def league(self) -> League:
        """The league, in its working place; what was committed is gone on with."""
        folder, kept = self.work / "league", self.kept / "league"
        if not folder.exists() and kept.exists():
            with making(folder) as made:
                shutil.copytree(kept, made, dirs_exist_ok=True)
        found = {
            run: self.places.folder(run) for run in self.starters()
        }  # with what learns on, where they are still there
        starters = {
            run.name: folder / "policy" if folder else self.places.kept(run).policy
            for run, folder in found.items()
        }
        return League.create(folder, self.settings, starters)

    def _after(self, league: League, k: int, say: Say) -> None:
        if k > 0 and not (self.kept / "league" / f"iteration_{k:02d}").exists():
            league.keep(self.kept / "league")
        say(f"league: iteration {k} of {self.settings.iterations} is done")

    def combined(self, league: League) -> list[CaiSpec]:
        """CAI: of the two best, against whom the last iteration kept, the best of each before, and bots."""
        last, settings = league.kept(self.settings.iterations), self.settings
        specs = []
        for number, side in enumerate(self.sides if settings.split else self.students * [BOTH]):
            camp = CAMPS[0] if side == BOTH else side
            enemy = CAMPS[1 - CAMPS.index(camp)]
            share = settings.partner_share / len(last[enemy])
            weights: dict[object, float] = dict.fromkeys((one.folder for one in last[enemy]), share)
            for player, weight in league.others(settings.iterations + 1, camp):
                weights[player] = weights.get(player, 0.0) + weight
            specs.append(
                CaiSpec(
                    side=side,
                    teachers=tuple(last[camp][:2]),
                    lessons=self.lessons,
                    opponents=list(weights.items()),
                    games=self.cai_games,
                    fill_games=settings.fill_games,
                    refit_games=settings.refit_games,
                    seed=(settings.seed, settings.iterations + 1, number),
                    folder=self.work / "cai" / f"{side}-{number}",
                    env=league.env(),
                    learner={**league.learner(self.cai_games), **self.cai_learner},
                    about=league.terms.about(),
                )
            )
        return specs

    def progress(self, league: League) -> dict[str, dict[int, Estimate]]:
        """Win rate of the best models of each iteration, both colours, against HRL0, the bots and whom they never met."""
        how = replace(self.evaluation, games=self.progress_games)
        best = {
            camp: {str(k): str(league.kept(k)[camp][0].folder) for k in self._iterations} for camp in CAMPS
        }
        found: dict[str, dict[int, Estimate]] = {}
        for name in ("HRL0", *PROGRESS):
            rival = name if name in PROGRESS else str(self.best_warm_up())
            reds, blues = ({**best[camp], name: rival} for camp in CAMPS)
            pairs = [(str(k), name) for k in self._iterations] + [(name, str(k)) for k in self._iterations]
            meetings = [Meeting(red=red, blue=blue, scenario=self.settings.scenario) for red, blue in pairs]
            table = play_meetings(meetings, reds, blues, how, self.work / "progress", jobs=self.jobs)
            found[name] = {k: table.win_rate(str(k), *CAMPS) for k in self._iterations}
        return found

    @property
    def _iterations(self) -> range:
        return range(self.settings.iterations + 1)

    @property
    def evaluation(self) -> Evaluation:
        """Matches of the table: fresh games, that nothing was trained or selected on."""
        terms = Terms(scenario=self.settings.scenario)
        return Evaluation(terms=terms, games=self.games, seed=self.settings.seed)

    def _keep_policies(self, league: League) -> None:
        """Copy the policies of the table."""
        first, last = league.kept(0), league.kept(self.settings.iterations)
        for side in self.sides:
            camp, combined = CAMPS[0] if side == BOTH else side, self._best_student(league, side)
            found = {
                "HRL0": self.best_warm_up(),
                "HRL1": last[camp][0].folder,
                "HRL2": last[camp][1].folder,
                BROAD: first[camp][0].folder,
                DISTILLED: combined / DISTILLED,
                "CAI": combined / LEARNED,
            }
            for name, folder in found.items():
                target = self.policy(name, side)
                if not target.exists():
                    with making(target) as made:
                        _copy_policy(folder, made)

    def _best_student(self, league: League, side: str) -> Path:
        """Folder of the student that does best against the opponents, by games that select."""
        folders = {spec.folder.name: spec.folder for spec in self.combined(league) if spec.side == side}
        if len(folders) == 1:
            return next(iter(folders.values()))
        models: dict[str, object] = {name: folder / LEARNED for name, folder in folders.items()}
        matches = self.work / "cai" / "matches"
        both = dict.fromkeys(CAMPS, models)
        rows = league.rank(both, self.settings.iterations + 1, matches, self.jobs)
        return folders[select(rows, 1, split=False)[CAMPS[0]][0]]

    def policy(self, name: str, side: str) -> Path:
        """Committed folder of a policy of the table."""
        return self.kept / "policies" / name.replace(" ", "-") / side

    def players(self, camp: str) -> dict[str, object]:
        """Players of a camp, by the name of their row or column."""
        side = camp if self.settings.split else BOTH
        policies = {name: self.policy(name, side) for name in (*ROWS, *FURTHER)}
        return {**policies, **{bot: bot for bot in (*BOTS, *PLAYERS)}}

    def meetings(self) -> list[Meeting]:
        """Every row against every column, in both colours."""
        rows = (*ROWS, *FURTHER, *CONSTANT_PLANS)
        pairs = [(a, b) for row in rows for column in COLUMNS for a, b in ((row, column), (column, row))]
        return [
            Meeting(red=red, blue=blue, scenario=self.settings.scenario) for red, blue in dict.fromkeys(pairs)
        ]

    def measure(self) -> Table:
        """Play the matches of the table."""
        reds, blues = (self.players(camp) for camp in CAMPS)
        folder, meetings = self.work / "matches", self.meetings()
        unpack(self.matches, folder)
        is_whole = all((folder / meeting.file).exists() for meeting in meetings)
        with nullcontext() if is_whole else measured(self.kept, "matches"):
            table = play_meetings(meetings, reds, blues, self.evaluation, folder, jobs=self.jobs)
        pack(table, self.matches)
        return table

    @property
    def matches(self) -> Path:
        """File of all matches."""
        return self.kept / "matches.json"

    def costs(self) -> Cost:
        """Wall and core time of every stage, as far as it was measured."""
        kept = [self.places.kept(run) for run in (*self.warm_ups(), *self.starters())]
        seconds = [60.0 * run.core_minutes for run in kept]
        warm_ups = {"warm-ups": {"wall_s": sum(seconds), "core_s": sum(seconds)}}
        league = [read_cost(self.kept / "league" / f"iteration_{k:02d}") for k in self._iterations]
        return added([warm_ups, *league, read_cost(self.kept)])


def _copy_policy(folder: Path, made: Path) -> None:
    """Copy what plays, without what learns on."""
    shutil.copytree(folder, made, dirs_exist_ok=True, ignore=shutil.ignore_patterns(NETWORKS))
