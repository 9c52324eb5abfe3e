"""The league: its folder is its state. Killed anywhere, it goes on there and ends the same (Fig. 6).

* `league.json`: settings, and what the figures depend on.
* `iteration_00/models/NAME/`: the models that it began with; `iteration_00/table.json`: how they did against their opponents.
* `iteration_03/groups/3-m0/both/`: what iteration 3 made of the best model; with `split`, `3-r0b2/red/` and `3-r0b2/blue/`: of
  the best red model and the third best blue one.
* `iteration_03/table.json`: the round robin of all of them, who was kept, and whom they come from.
"""

from __future__ import annotations

import re
import shutil
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any, Self

from hexwar_sb3.errors import FileFormatError, HexWarError
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.files import check_held, write_json
from hexwar_sb3.kinds import fits, read_fields
from hexwar_sb3.league.member import BOTH, CAMPS, Member
from hexwar_sb3.league.selection import Standing
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.reading import check_names, read_json

FORMAT = "hexwar league 4"
TABLE_KEYS = ("iteration", "kept", "standings", "red_win_rates")  # of an iteration's table
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,79}")
Generation = dict[str, list[Member]]  # by camp, the best first


@dataclass(frozen=True, kw_only=True)
class TableRow:
    """A row of an iteration's table, as its file has it."""

    name: str
    score: float  # that selects
    win_rate: float
    win_rate_interval: tuple[float, float]
    behind: float  # of the best against some rival, at most
    mean_margin: float
    parent: str | None  # none in the first iteration


@dataclass(frozen=True)
class LeagueFolder:
    """What lies in a league's folder, checked as it is read: a stranger may have written it."""

    folder: Path
    settings: LeagueSettings

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Read a league's settings.

        Raises:
            FileFormatError: the file is missing or broken, a setting is out of its range, or it is of other rules, bots
                or scenario.
        """
        path = folder / "league.json"
        found = read_json(path)
        if found.get("format") != FORMAT or not isinstance(found.get("settings"), dict):
            said = f"{str(found.get('format'))[:40]!r} with {str(found.get('settings'))[:60]}"
            raise FileFormatError(path, "format", found=said, expected=f"{FORMAT!r} with settings")
        values = read_fields(LeagueSettings, found["settings"], path, whole=True)
        try:
            settings = LeagueSettings(**values)
            origin = provenance(settings.scenario)
        except HexWarError as error:
            raise FileFormatError(
                path, "settings", found=str(error), expected="settings of a league"
            ) from error
        check_names(found, {"format": "", "settings": "", **origin}, path)
        for key, value in origin.items():
            if key != "software" and found.get(key) != value:
                raise FileFormatError(path, key, found=str(found.get(key)), expected=value)
        return cls(folder, settings)

    def write_head(self) -> None:
        """Write down the settings, and what the figures depend on."""
        head = {"format": FORMAT, "settings": asdict(self.settings), **provenance(self.settings.scenario)}
        write_json(self.folder / "league.json", head)

    @property
    def starters_folder(self) -> Path:
        """Policies that the league began with."""
        return self.iteration(0) / "models"

    def starters(self, camp: str) -> list[Member]:
        """Models that the league began with, as far as they were trained in a camp."""
        folders = sorted(path for path in self.starters_folder.glob("*") if NAME.fullmatch(path.name))
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
                for share in ("score", "win_rate", "behind"):
                    if not 0.0 <= own[share] <= 1.0:
                        expected = "a share in 0..1"
                        raise FileFormatError(
                            path, f"{place}.{share}", found=str(own[share]), expected=expected
                        )
                rows.setdefault(camp, []).append(own)
        return rows

    def red_win_rates(self, k: int) -> dict[str, float]:
        """Win rates of red in iteration k's round robin, by "RED BLUE"; none in iteration 0.

        Raises:
            FileFormatError: its table is broken.
        """
        found = self._table(k).get("red_win_rates", {})
        for names, rate in found.items() if isinstance(found, dict) else [("", found)]:
            if not fits(rate, float) or not 0.0 <= rate <= 1.0 or len(names.split(" ")) != len(CAMPS):
                place, expected = "red_win_rates", "shares in 0..1 by two names"
                raise FileFormatError(
                    self.table(k), place, found=f"{names!r}: {rate!r}"[:80], expected=expected
                )
        return dict(found)

    def models(self, k: int) -> Generation:
        """All models of an iteration: those that it trained, and, where one plays both camps, those they come from."""
        if k == 0:
            return {camp: self.starters(camp) for camp in CAMPS}
        names = [group_name(k, *places) for places in self.groups]
        folders = {camp: camp if self.settings.split else BOTH for camp in CAMPS}
        new = {
            camp: [Member(camp, name, self.group(k, name) / folders[camp]) for name in names]
            for camp in CAMPS
        }
        if self.settings.split:
            return new
        return {camp: [*new[camp], *dict.fromkeys(self.kept(k - 1)[camp])] for camp in CAMPS}

    @property
    def groups(self) -> list[tuple[int, ...]]:
        """Who trains in an iteration, by their places among those that were kept: each, or every red with every blue one."""
        return list(product(range(self.settings.keep), repeat=1 + self.settings.split))

    def group(self, k: int, name: str) -> Path:
        """Folder of a group of an iteration."""
        return self.iteration(k) / "groups" / name

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
                    if not place.exists():  # else an earlier iteration kept it too
                        member.policy().save(place)
                    if k == done[-1] and member.networks.is_file():
                        shutil.copyfile(member.networks, place / member.networks.name)
        old = folder.with_name(f".old-{folder.name}")
        shutil.rmtree(old, ignore_errors=True)
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
        shutil.rmtree(old, ignore_errors=True)


def _named(row: object) -> dict[str, Any]:
    """A row of a table; an empty one, which lacks everything, in place of what is none."""
    return row if isinstance(row, dict) else {}


def group_name(k: int, *places: int) -> str:
    """Name of a group: its iteration, and the places of its models, or of its red and its blue one, among those kept."""
    return f"{k}-r{places[0]}b{places[1]}" if len(places) > 1 else f"{k}-m{places[0]}"
