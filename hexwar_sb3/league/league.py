"""The league: its folder is its state. Killed anywhere, it goes on there and ends the same (Fig. 6).

* `league.json`: settings, and what the figures depend on.
* `iteration_00/models/NAME/`: the models that it began with; `iteration_00/table.json`: how they did against the bots.
* `iteration_03/groups/3-r0b2/both/`: what iteration 3 made of the best model in the group with the third best; with
  `split`, `red/` and `blue/`: of the best red model and the third best blue one.
* `iteration_03/table.json`: the round robin of all of them, who was kept, and whom they come from.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from hexwar_sb3.algorithms.presets import FALLS
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.panel import BOTS
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.files import check_held, write_json
from hexwar_sb3.folders import holding
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.league.cost import measured
from hexwar_sb3.league.group import GroupSpec, train_group
from hexwar_sb3.league.member import BOTH, CAMPS, Member
from hexwar_sb3.league.selection import Standing, play_all, select, standings
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.league.work import Opponents, env_settings, env_steps, job_seed
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.terms import Terms, trained_terms
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.reading import check_names, read_json
from hexwar_sb3.tasks.hotspots import is_mirrored

FORMAT = "hexwar league 2"
TABLE_KEYS = ("iteration", "kept", "standings", "red_win_rates")  # of an iteration's table
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,79}")
Generation = dict[str, list[Member]]  # by camp, the best first


@dataclass(frozen=True, kw_only=True)
class TableRow:
    """A row of an iteration's table, as its file has it."""

    name: str
    win_rate: float
    win_rate_interval: tuple[float, float]
    mean_margin: float
    parent: str | None  # none in the first iteration


@dataclass(frozen=True)
class League:
    """Grouped self-play (III-C, Fig. 6) in a folder."""

    folder: Path
    settings: LeagueSettings

    @classmethod
    def open(cls, folder: Path) -> League:
        """Read a league's settings.

        Raises:
            FileFormatError: the file is missing or broken, of other rules, bots or scenario.
            ConfigError: a setting is out of its range.
        """
        path = folder / "league.json"
        found = read_json(path)
        if found.get("format") != FORMAT or not isinstance(found.get("settings"), dict):
            said = f"{str(found.get('format'))[:40]!r} with {str(found.get('settings'))[:60]}"
            raise FileFormatError(path, "format", found=said, expected=f"{FORMAT!r} with settings")
        settings = LeagueSettings(**read_fields(LeagueSettings, found["settings"], path, whole=True))
        origin = provenance(settings.scenario)
        check_names(found, {"format": "", "settings": "", **origin}, path)
        for key, value in origin.items():
            if key != "software" and found.get(key) != value:
                raise FileFormatError(path, key, found=str(found.get(key)), expected=value)
        return cls(folder, settings)

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
            shutil.rmtree(league._starters, ignore_errors=True)  # of a beginning that was broken off
            for name, policy in policies.items():
                policy.save(league._starters / name)
            league._write_head()
            return league

    def _write_head(self) -> None:
        head = {"format": FORMAT, "settings": asdict(self.settings), **provenance(self.settings.scenario)}
        write_json(self.folder / "league.json", head)

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
        league._write_head()
        return league

    def check_starters(self, starters: Mapping[str, FrozenPolicy]) -> None:
        """Whether it began with these; none are any.

        Raises:
            ConfigError: it began with others.
        """
        known = {path.name: path for path in self._starters.glob("*") if NAME.fullmatch(path.name)}
        if starters and set(starters) != set(known):
            began, given = (", ".join(sorted(names)) for names in (known, starters))
            raise ConfigError(f"{self.folder} holds a league that began with {began}, not with {given}")
        for name, policy in starters.items():
            if Member("", name, known[name]).policy().sha256 != policy.sha256:
                raise ConfigError(f"{self.folder} holds a league that began with another {name}")

    @property
    def _starters(self) -> Path:
        return self.iteration(0) / "models"

    def starters(self, camp: str) -> list[Member]:
        """Models that the league began with, as far as they were trained in a camp."""
        folders = sorted(path for path in self._starters.glob("*") if NAME.fullmatch(path.name))
        members = [Member(camp, path.name, path) for path in folders]
        return [one for one in members if one.policy().about.get("side", "both") in (camp, "both")]

    def iteration(self, k: int) -> Path:
        """Folder of an iteration."""
        return self.folder / f"iteration_{k:02d}"

    def table(self, k: int) -> Path:
        """File with the standings of an iteration, and who was kept."""
        return self.iteration(k) / "table.json"

    def is_done(self, k: int) -> bool:
        """The round robin of an iteration is over, and who is kept is known."""
        return self.table(k).is_file()

    def kept(self, k: int) -> Generation:
        """Models that iteration k kept, the best first.

        Raises:
            FileFormatError: its table is broken.
        """
        path = self.table(k)
        kept, known = self._table(k).get("kept"), self.models(k)
        found: Generation = {}
        for camp in CAMPS:
            by_name = {member.name: member for member in known[camp]}
            names = kept.get(camp) if isinstance(kept, dict) else None
            if (
                not isinstance(names, list)
                or not all(isinstance(name, str) for name in names)
                or len(names) != self.settings.keep
                or not set(names) <= set(by_name)
            ):
                raise FileFormatError(
                    path,
                    f"kept.{camp}",
                    found=str(names)[:80],
                    expected=f"{self.settings.keep} models of this iteration",
                )
            found[camp] = [by_name[name] for name in names]
        return found

    def _table(self, k: int) -> dict[str, Any]:
        found = read_json(self.table(k))
        check_names(found, dict.fromkeys(TABLE_KEYS), self.table(k))
        return found

    def standings(self, k: int) -> dict[str, list[Standing]]:
        """Rows of iteration k's table by camp, the best first.

        Raises:
            FileFormatError: its table is broken.
        """
        path = self.table(k)
        found, rows = self._table(k).get("standings"), dict[str, list[Standing]]()
        for camp in CAMPS:
            listed = found.get(camp) if isinstance(found, dict) else None
            if not isinstance(listed, list) or not listed:
                raise FileFormatError(path, f"standings.{camp}", found=str(listed), expected="rows of models")
            for n, row in enumerate(listed):
                place = f"standings.{camp}[{n}]"
                own = read_fields(TableRow, {"parent": None, **_named(row)}, path, place=place, whole=True)
                if not 0.0 <= own["win_rate"] <= 1.0:
                    place = f"{place}.win_rate"
                    raise FileFormatError(path, place, found=str(own["win_rate"]), expected="a share in 0..1")
                rows.setdefault(camp, []).append(own)
        return rows

    def models(self, k: int) -> Generation:
        """All models of an iteration."""
        if k == 0:
            return {camp: self.starters(camp) for camp in CAMPS}
        names = [group_name(k, i, j) for i in range(self.settings.keep) for j in range(self.settings.keep)]
        folders = {camp: camp if self.settings.split else BOTH for camp in CAMPS}
        return {
            camp: [Member(camp, name, self.group(k, name) / folders[camp]) for name in names]
            for camp in CAMPS
        }

    def group(self, k: int, name: str) -> Path:
        """Folder of a group of an iteration."""
        return self.iteration(k) / "groups" / name

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
        """Order the first models by their games against the bots; the best of a colour is HRL0."""
        if self.is_done(0):
            return
        rows, how = {}, self.evaluation(0, self.settings.warm_up_games)
        bots: dict[str, object] = {bot: bot for bot in BOTS}
        for camp in CAMPS:
            models: dict[str, object] = {member.name: member.folder for member in self.starters(camp)}
            red, blue = (models, bots) if camp == "red" else (bots, models)
            table = play_all(red, blue, how, self.iteration(0) / "matches" / camp, jobs=jobs)
            rows[camp] = standings(table, camp)
        kept = select(rows, self.settings.keep, split=self.settings.split)
        write_json(self.table(0), {"iteration": 0, "kept": kept, "standings": rows})

    def _train_groups(self, k: int, jobs: int) -> None:
        run_jobs(train_group, [spec for spec in self.specs(k) if not spec.folder.is_dir()], jobs, "group")

    def specs(self, k: int) -> list[GroupSpec]:
        """What the groups of an iteration depend on: the models that were kept, and those before them."""
        kept, settings = self.kept(k - 1), self.settings
        others = {camp: self.others(k, camp) for camp in CAMPS}
        return [
            GroupSpec(
                members={"red": kept["red"][i], "blue": kept["blue"][j]},
                others=others,
                partner_share=settings.partner_share,
                split=settings.split,
                games=settings.games,
                fill_games=settings.fill_games,
                refit_games=settings.refit_games,
                seed=(settings.seed, k, i, j),
                folder=self.group(k, group_name(k, i, j)),
                env=self.env(),
                learner=self.learner(settings.games),
                about=self.terms.about(),
            )
            for i in range(settings.keep)
            for j in range(settings.keep)
        ]

    def learner(self, games: int) -> dict[str, Any]:
        """Arguments of QMIX for so many games."""
        falls = {name: max(1, int(share * games)) for name, share in FALLS.items()}
        widths = {"hidden": self.settings.hidden, "embed": self.settings.embed}
        return {**falls, **self.settings.learner, "policy_kwargs": {**widths, "mirrored": self._is_mirrored}}

    @property
    def _is_mirrored(self) -> bool:
        """Whether models do not see which camp they play."""
        return is_mirrored(load_world(self.settings.scenario).scenario)

    def others(self, k: int, camp: str) -> Opponents:
        """Whom models of a colour meet beside their partners: the best of the iterations before, and bots."""
        settings = self.settings
        past = dict.fromkeys((str(member.folder) for member in self._best_before(k, camp)), 1.0)
        found: list[tuple[object, float]] = []
        for players, share in ((past, settings.past_share), (settings.weights, settings.bots_share)):
            total = sum(players.values())
            found += [(player, share * weight / total) for player, weight in players.items() if share > 0]
        return found

    def _best_before(self, k: int, camp: str) -> list[Member]:
        """The best of the other colour, of each iteration before k."""
        enemy = CAMPS[1 - CAMPS.index(camp)]
        return [self.kept(before)[enemy][0] for before in range(k)]

    def _select(self, k: int, jobs: int) -> None:
        models = self.models(k)
        reds, blues = ({one.name: one.folder for one in models[camp]} for camp in CAMPS)
        how = self.evaluation(k, self.settings.match_games)
        bots, share = tuple(self.settings.weights), self.settings.worst_share
        table = play_all(reds, blues, how, self.iteration(k) / "matches", bots=bots, jobs=jobs)
        rows = {camp: standings(table, camp, bots, share) for camp in CAMPS}
        before = self.kept(k - 1)
        for camp in CAMPS:
            for row in rows[camp]:
                row["parent"] = before[camp][
                    parent_of(row["name"], camp if self.settings.split else "red")
                ].name
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

    @property
    def terms(self) -> Terms:
        """Of all games: as the first models were trained."""
        return replace(trained_terms(self.starters("red")[0].folder), scenario=self.settings.scenario)

    def evaluation(self, k: int, games: int) -> Evaluation:
        """Games that select in iteration k."""
        seed = job_seed(self.settings.seed, k)
        return Evaluation(terms=self.terms, games=games, seed=seed, purpose=Purpose.SELECTION)

    def keep(self, folder: Path, *, models: bool = True) -> None:
        """Copy what it takes to go on: tables, the best of each iteration, and all that the last one kept.

        Args:
            folder: of the copy; what is there is replaced.
            models: False if the league is over, and tables and the models that it began with are all that is wanted.
        """
        done = [k for k in range(self.settings.iterations + 1) if self.is_done(k)]
        check_held(folder.parent)
        new = folder.with_name(f".new-{folder.name}")
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir(parents=True)
        shutil.copyfile(self.folder / "league.json", new / "league.json")
        for k in done:
            place = self.iteration(k).relative_to(self.folder)
            (new / place).mkdir()
            for file in self.iteration(k).glob("*.json"):
                shutil.copyfile(file, new / place / file.name)
            generation = self.models(0) if k == 0 else self.kept(k) if models else {}
            for members in generation.values():
                for member in members if k in (0, done[-1]) else members[:1]:
                    place = new / member.folder.relative_to(self.folder)
                    member.policy().save(place)
                    if k == done[-1] and member.networks.is_file():
                        shutil.copyfile(member.networks, place / member.networks.name)
        old = folder.with_name(f".old-{folder.name}")
        shutil.rmtree(old, ignore_errors=True)
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
        shutil.rmtree(old, ignore_errors=True)

    @property
    def env_steps(self) -> int:
        """Env steps of all groups together, mixers that were refitted apart."""
        groups = self.settings.keep**2 * self.settings.iterations
        return (1 + self.settings.split) * groups * env_steps(self.env(), self.settings.games)

    def env(self) -> dict[str, Any]:
        """Settings of the task env."""
        return {
            **env_settings(self.terms, self.settings.n_envs),
            "priority": self.settings.priority,
        }


def _named(row: object) -> dict[str, Any]:
    """A row of a table; an empty one, which lacks everything, in place of what is none."""
    return row if isinstance(row, dict) else {}


def group_name(k: int, i: int, j: int) -> str:
    """Name of a group: its iteration, and the places of its red and blue model among those that were kept."""
    return f"{k}-r{i}b{j}"


def parent_of(name: str, camp: str) -> int:
    """Place of a model's parent among the models of its colour that were kept."""
    red, _, blue = name.partition("-r")[2].partition("b")
    return int(red if camp == "red" else blue)


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
    env = make_vec_env(TASK_ENV, seed=0, **env_settings(terms, n_envs=1))
    shapes = TaskShapes.of(env.observation_space, env.action_space)
    has = (shapes.n_pieces, shapes.n_tasks, shapes.obs_dim, shapes.task_dim)
    for name, policy in policies.items():
        needs = (policy.n_pieces, policy.n_tasks, policy.sizes["obs"], policy.sizes["task"])
        if needs != has:
            raise ConfigError(
                f"{name} has (pieces, tasks, features, task features) {needs}, {settings.scenario} {has}"
            )
