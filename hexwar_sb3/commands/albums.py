"""Pages of many games, of what lies in a folder: a training, a tournament, a league, or just replays."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.engine.replay_file import replays_in
from hexwar_sb3.errors import ConfigError, HexWarError
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.played import read_matches, table_of_rates
from hexwar_sb3.viewer.album import Album, Clip, clips_of
from hexwar_sb3.viewer.cover import curve_part, table_part

if TYPE_CHECKING:
    from hexwar_sb3.evaluation.tournament import Table
    from hexwar_sb3.league.league import League

PAIR = 2  # games that are shown side by side
SNAPSHOT_GAME = re.compile(r"(red|blue)_(\d{9})_against_(.+)")  # name of a game in an album of a run
Told = dict[str, Any]


def album_of(places: Sequence[Path], view: str = "all") -> Album:
    """The page of a folder, or of replays.

    Raises:
        ConfigError: a folder among several places, or nothing to show.
        FileFormatError: a file in the folder is broken.
    """
    folders = [place for place in places if place.is_dir()]
    if not folders:
        cover = {"kind": "compare" if len(places) == PAIR else "games"}
        return Album(title=f"{len(places)} recorded games", clips=clips_of(places, view), cover=cover)
    if len(places) > 1:
        raise ConfigError(f"{folders[0]} is a folder: name one folder, or replays")
    (folder,) = folders
    if (folder / "league.json").is_file():
        found = league_album(folder)
    elif (folder / "matches").is_dir():
        found = tournament_album(folder)
    elif (folder / "snapshots").is_dir() or (folder / "replays").is_dir():
        found = run_album(folder)
    else:
        paths = [path for path in replays_in(folder) if path.parent == folder]
        found = Album(title=folder.resolve().name, clips=clips_of(paths))
    if not found.clips and "tables" not in found.cover:
        raise ConfigError(f"{folder}: no recorded games; expected a run, a tournament, a league, or *.hwr")
    return replace(found, clips=[replace(clip, view=view) for clip in found.clips])


def save_at_end(album: Callable[[], Album], path: Path, jobs: int = 1) -> None:
    """Write the page of what a command has made; what is wrong with it is said, and no more: the command is done."""
    try:
        album().save(path, jobs=jobs)
    except HexWarError as error:
        print(f"no page: {error}", file=sys.stderr)


# --- a training ----------------------------------------------------------------------------------


def run_album(folder: Path) -> Album:
    """How the commander changed: its snapshots in one game, the first one first, and its learning curve.

    Raises:
        FileFormatError: the evaluations, or the settings, are broken.
    """
    run = RunFolder(folder)
    found = [(SNAPSHOT_GAME.fullmatch(path.stem), path) for path in sorted(run.replays.glob("*.hwr"))]
    games = sorted((int(match[2]), path) for match, path in found if match)
    from_nothing = not (run.config.is_file() and run.read_config().get("trained_agent"))
    clips = [Clip(path=path, name=_age(steps, from_nothing=from_nothing)) for steps, path in games]
    numbers = {steps: number for number, (steps, _) in enumerate(games, start=1)}
    cover: Told = {"kind": "album"}
    evaluations = folder / "evaluations.npz"
    if evaluations.is_file():
        cover["curve"] = curve_part(History.load(evaluations), numbers)
    return Album(title=f"How {folder.resolve().name} learned", clips=clips, cover=cover)


def _age(steps: int, *, from_nothing: bool) -> str:
    """What a snapshot is called."""
    if steps == 0:
        return "untrained" if from_nothing else "as it began"
    return f"{steps:,} steps"


# --- a tournament --------------------------------------------------------------------------------


def tournament_album(folder: Path) -> Album:
    """Who beat whom, a table a map; a cell leads to the median game of its match.

    Raises:
        FileFormatError: a match is broken.
    """
    table = read_matches(folder / "matches")
    clips, numbers = _games(folder / "games", table)
    tables = [table_part(table, scenario, numbers) for scenario in table.scenarios]
    title = f"Who beats whom: {folder.resolve().name}"
    return Album(title=title, clips=clips, cover={"kind": "league", "tables": tables})


def _games(folder: Path, table: Table) -> tuple[list[Clip], dict[str, int]]:
    """The recorded games of a table's matches, and their numbers by the stems of these."""
    stems = {meeting.stem: f"{meeting.red} against {meeting.blue}" for meeting in table.rows}
    found = [stem for stem in stems if (folder / f"{stem}.hwr").is_file()]
    clips = [Clip(path=folder / f"{stem}.hwr", name=stems[stem]) for stem in found]
    return clips, {stem: number for number, stem in enumerate(found, start=1)}


# --- a league ------------------------------------------------------------------------------------


def league_album(folder: Path) -> Album:
    """The round robins of a league, the last one first and with its games, and who comes from whom.

    Raises:
        FileFormatError: the league, a table or a match is broken.
    """
    from hexwar_sb3.league.league import League

    league = League.open(folder)
    done = [k for k in range(league.settings.iterations + 1) if league.is_done(k)]
    clips, tables = list[Clip](), []
    for k in reversed([k for k in done if k > 0]):
        table = _round_robin(league, k)
        own, numbers = _games(league.iteration(k) / "games", table) if not clips else ([], {})
        clips += own
        name = f"iteration {k}"
        tables += [table_part(table, scenario, numbers, name) for scenario in table.scenarios]
    cover = {"kind": "league", "tables": tables, "lineage": _lineage(league, done)}
    return Album(title=f"League: {folder.resolve().name}", clips=clips, cover=cover)


def _round_robin(league: League, k: int) -> Table:
    matches = league.iteration(k) / "matches"
    if matches.is_dir():
        return read_matches(matches)
    games = league.settings.match_games
    return table_of_rates(league.red_win_rates(k), Path(league.settings.scenario).name, games)


def _lineage(league: League, done: Sequence[int]) -> dict[str, list[list[Told]]]:
    """By colour and iteration the models that were kept, the best first: whom each was trained from, how often it won."""
    camps = ("red", "blue") if league.settings.split else ("red",)
    names = camps if league.settings.split else ("both",)
    return {
        name: [
            _generation(league.standings(k)[camp], [one.name for one in league.kept(k)[camp]]) for k in done
        ]
        for name, camp in zip(names, camps, strict=True)
    }


def _generation(rows: Sequence[Mapping[str, Any]], kept: Sequence[str]) -> list[Told]:
    by_name = {row["name"]: row for row in rows}
    return [
        {"name": name, "parent": by_name[name]["parent"], "rate": round(by_name[name]["win_rate"], 4)}
        for name in dict.fromkeys(kept)
        if name in by_name
    ]
