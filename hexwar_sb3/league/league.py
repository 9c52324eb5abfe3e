"""Grouped self-play (III-C, Fig. 6). Killed anywhere, a league goes on there and ends the same: its folder is its state."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.evaluation.tournament import Table, record_medians
from hexwar_sb3.files import write_json
from hexwar_sb3.folders import holding
from hexwar_sb3.league.agenda import Agenda
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.folder import NAME, group_name
from hexwar_sb3.league.group import train_group
from hexwar_sb3.league.member import BOTH, CAMPS, Member, leave_copy
from hexwar_sb3.league.selection import Standing, play_all, select, standings
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.league.work import env_settings
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.policies.shapes import TaskShapes


@dataclass(frozen=True)
class League(Agenda):
    """Grouped self-play (III-C, Fig. 6): a league that is begun, prolonged and run."""

    @classmethod
    def create(cls, folder: Path, settings: LeagueSettings, starters: Mapping[str, Path]) -> League:
        """Begin a league, or go on with the one that lies there.

        Args:
            folder: of the league.
            settings: of it.
            starters: policy folders by name; one that was trained in both colours is in both.

        Raises:
            ConfigError: there is a league of other settings or starters, a colour has no starter, one is wider than the
                league's models or was trained with other pieces than the scenario's, or the starters differ in
                decision ticks, hot spots or decision points.
            UnknownNameError: no such bot or scenario.
            PolicyFileError: a starter is broken.
            CheckpointError: the model of the run that it comes from is.
            BusyError: another process works on it.
        """
        policies = {name: Member("", name, path).policy() for name, path in starters.items()}
        if not (folder / "league.json").exists():
            _check_starters(policies, settings)
        with holding(folder, "league"):
            if (folder / "league.json").exists():
                league = cls.open(folder)
                league.check_starters(policies)
                return league.prolonged(settings)
            league = cls(folder, settings)
            shutil.rmtree(league.starters_folder, ignore_errors=True)  # of a beginning that was broken off
            like = league.new_model(next(iter(policies.values()))).policy
            for name, policy in policies.items():
                leave_copy(policy, starters[name], league.starters_folder / name, like)
            league.write_head()
            return league

    def new_model(self, policy: FrozenPolicy) -> QMIX:
        """A model such as the league's, which has learned nothing.

        Args:
            policy: of the first model, whose terms are the league's.
        """
        terms = replace(trained_terms(policy), scenario=self.settings.scenario)
        env = make_vec_env(TASK_ENV, seed=0, **env_settings(terms, n_envs=1))
        return QMIX("TaskPolicy", env, seed=0, **{**self.learner(1), "buffer_size": 10})

    def prolonged(self, settings: LeagueSettings) -> League:
        """The same league, perhaps with more iterations.

        Raises:
            ConfigError: it has other settings, or more iterations already.
        """
        longer = replace(self.settings, iterations=max(self.settings.iterations, settings.iterations))
        if settings != longer:
            found = _difference(self.settings, settings)
            raise ConfigError(f"{self.folder} holds a league of other settings: {found}")
        league = League(self.folder, settings)
        league.write_head()
        return league

    def check_starters(self, starters: Mapping[str, FrozenPolicy]) -> None:
        """Whether it began with these; none are any.

        Raises:
            ConfigError: it began with others.
        """
        known = {path.name: path for path in self.starters_folder.glob("*") if NAME.fullmatch(path.name)}
        if starters and set(starters) != set(known):
            began, given = (", ".join(sorted(names)) for names in (known, starters))
            raise ConfigError(f"{self.folder} holds a league that began with {began}, not with {given}")
        for name, policy in starters.items():
            if Member("", name, known[name]).policy().sha256 != policy.sha256:
                raise ConfigError(f"{self.folder} holds a league that began with another {name}")

    def run(self, jobs: int = 1, after: Callable[[int], object] = id) -> None:
        """Make the iterations that are missing.

        Args:
            jobs: groups, then matches, side by side.
            after: called with the number of each iteration that is done.

        Raises:
            BusyError: another process works on it.
            FileNotFoundError: its folder was removed meanwhile.
        """
        with holding(self.folder, "league"):
            self._rank_starters(jobs)
            after(0)
            for k in range(1, self.settings.iterations + 1):
                if not self.is_done(k):
                    self._iterate(k, jobs)
                after(k)

    def _iterate(self, k: int, jobs: int) -> None:
        with measured(self.iteration(k), "groups"):
            self._train_groups(k, jobs)
        with measured(self.iteration(k), "round robin"):
            self._select(k, jobs)

    def _rank_starters(self, jobs: int) -> None:
        """Order the first models by their games against the opponents."""
        if self.is_done(0):
            return
        models = {camp: {one.name: one.folder for one in self.starters(camp)} for camp in CAMPS}
        rows = self.rank(models, 0, self.iteration(0) / "matches", jobs)
        kept = select(rows, self.settings.keep, split=self.settings.split)
        write_json(self.table(0), {"iteration": 0, "kept": kept, "standings": rows})

    def rank(
        self, models: Mapping[str, Mapping[str, object]], k: int, folder: Path, jobs: int = 1
    ) -> dict[str, list[Standing]]:
        """Standings of models by their games against the opponents alone, by camp.

        Args:
            models: by camp and name.
            k: iteration whose games select.
            folder: gets the matches.
            jobs: matches side by side.
        """
        how = self.evaluation(k, self.settings.warm_up_games)
        rivals: dict[str, object] = {name: name for name in self.settings.weights or BOTS}
        rows = {}
        for camp in CAMPS:
            red, blue = (models[camp], rivals) if camp == "red" else (rivals, models[camp])
            rows[camp] = standings(play_all(red, blue, how, folder / camp, jobs=jobs), camp)
        return rows

    def _train_groups(self, k: int, jobs: int) -> None:
        missing = [spec for spec in self.specs(k) if not spec.folder.is_dir()]
        run_jobs(train_group, missing, jobs, "group", leaves=lambda spec: [spec.folder])

    def _players(self, k: int) -> tuple[dict[str, object], dict[str, object]]:
        """Red and blue models of an iteration by name."""
        models = self.models(k)
        reds, blues = ({one.name: one.folder for one in models[camp]} for camp in CAMPS)
        return dict(reds), dict(blues)

    def _round_robin(self, k: int, jobs: int) -> Table:
        """Every red model of iteration k against every blue one, and their rivals; what was played is read."""
        how, folder = self.evaluation(k, self.settings.match_games), self.iteration(k) / "matches"
        return play_all(*self._players(k), how, folder, rivals=tuple(self.settings.weights), jobs=jobs)

    def record_games(self, k: int, jobs: int = 1, command: str | None = None) -> None:
        """Write down, into the iteration's `games/`, the median game of each match of those that iteration k kept.

        Args:
            k: an iteration that is done, not the first.
            jobs: games side by side.
            command: what made them, as one would type it.
        """
        rivals = {name: name for name in self.settings.weights}
        kept = {camp: {*rivals, *(one.name for one in self.kept(k)[camp])} for camp in CAMPS}
        with holding(self.folder, "league"):
            table = self._round_robin(k, jobs)
            own = {
                meeting: row
                for meeting, row in table.rows.items()
                if meeting.red in kept["red"] and meeting.blue in kept["blue"]
            }
            reds, blues = ({**players, **rivals} for players in self._players(k))
            how, folder = self.evaluation(k, self.settings.match_games), self.iteration(k) / "games"
            record_medians(Table(own), reds, blues, how, folder, jobs=jobs, command=command)

    def _select(self, k: int, jobs: int) -> None:
        rivals, share = tuple(self.settings.weights), self.settings.worst_share
        table = self._round_robin(k, jobs)
        rows = {camp: standings(table, camp, rivals, share) for camp in CAMPS}
        before = self.kept(k - 1)
        for n, camp in enumerate(CAMPS):
            parents = {
                group_name(k, *places): before[camp][places[n % len(places)]] for places in self.groups
            }
            for row in rows[camp]:
                row["parent"] = parents[row["name"]].name if row["name"] in parents else row["name"]
        wins = {
            f"{meeting.red} {meeting.blue}": row["red"]["win_rate"] for meeting, row in table.rows.items()
        }
        found = {
            "iteration": k,
            "kept": select(rows, self.settings.keep, split=self.settings.split),
            "standings": rows,
            "red_win_rates": wins,
        }
        write_json(self.table(k), found)


def _difference(mine: LeagueSettings, other: LeagueSettings) -> str:
    pairs = ((name, value, getattr(other, name)) for name, value in asdict(mine).items())
    return ", ".join(f"{name} {a}, not {b}" for name, a, b in pairs if a != b)


def _check_starters(policies: Mapping[str, FrozenPolicy], settings: LeagueSettings) -> None:
    """Both colours have a model, all can meet, and none is wider than the models that learn on from them.

    Raises:
        ConfigError: it is not so.
    """
    for name, policy in policies.items():
        if not NAME.fullmatch(name):
            raise ConfigError(f"a model's name is of letters, digits, '.', - and _, got {name!r}")
        widths = {"hidden": len(policy.weights["piece.weight"]), "embed": len(policy.weights["embed.weight"])}
        if widths["hidden"] > settings.hidden or widths["embed"] > settings.embed:
            most = {"hidden": settings.hidden, "embed": settings.embed}
            raise ConfigError(f"{name} is wider than the league's models: {widths}, not {most}")
    for camp in CAMPS:
        if not any(policy.about.get("side", BOTH) in (camp, BOTH) for policy in policies.values()):
            raise ConfigError(f"no model to begin with for {camp}")
    for name, policy in policies.items():
        if not settings.split and (side := policy.about.get("side", BOTH)) != BOTH:
            raise ConfigError(f"{name} plays {side} alone: it needs a league of split=True")
    ways = {
        name: replace(trained_terms(policy), scenario=settings.scenario) for name, policy in policies.items()
    }
    terms = next(iter(ways.values()))
    for name, way in ways.items():
        if way != terms:
            raise ConfigError(
                f"{name} was trained with {way.about()}, others with {terms.about()}: they cannot meet"
            )
    rivals = list(settings.weights.items()) or "MA1"
    env = make_vec_env(TASK_ENV, seed=0, opponent=rivals, **env_settings(terms, n_envs=1))  # HRL0 may not fit
    shapes = TaskShapes.of(env.observation_space, env.action_space)
    has = (shapes.n_pieces, shapes.n_tasks, shapes.obs_dim, shapes.task_dim)
    for name, policy in policies.items():
        needs = (policy.n_pieces, policy.n_tasks, policy.sizes["obs"], policy.sizes["task"])
        if needs != has:
            raise ConfigError(
                f"{name} has (pieces, tasks, features, task features) {needs}, {settings.scenario} {has}"
            )
