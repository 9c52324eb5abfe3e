"""Every player against every other on every map: matches that leave files, so that a tournament can go on.

Each match is a job of its own (`jobs`): they run one after the other, or side by side, on this machine or on a cluster.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.bots.config import bots_hash, drawn_hash
from hexwar_sb3.bots.registry import FAMILIES, as_member
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.elo import Pairing, Ratings, elo_ratings
from hexwar_sb3.evaluation.intervals import Estimate, wilson
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.parcels import as_place, at_hand
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.seeds import seed_for
from hexwar_sb3.files import write_entries, write_json
from hexwar_sb3.folders import holding
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.play.seeds import game_seed
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import BotPlayer, make_player
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.reading import read_json

FORMAT = "hexwar match 1"
MEDIAN = "median_game"  # of a match's file: number of its median game
LETTERS = {1.0: "W", 0.5: "D", 0.0: "L"}  # red's result of a game


@dataclass(frozen=True, kw_only=True)
class Meeting:
    """A match to play: who meets whom, and where."""

    red: str  # name of a player
    blue: str
    scenario: str

    @property
    def stem(self) -> str:
        """Name of its files, without a suffix."""
        return f"{Path(self.scenario).name}~{self.red}~{self.blue}"

    @property
    def file(self) -> str:
        """Name of the file of its figures."""
        return f"{self.stem}.json"


@dataclass(frozen=True, eq=False)
class Table:
    """What came of meetings: a row each, as JSON values."""

    rows: Mapping[Meeting, Mapping[str, Any]]

    @property
    def scenarios(self) -> list[str]:
        """Maps that were played."""
        return list(dict.fromkeys(meeting.scenario for meeting in self.rows))

    def ratings(self, scenario: str | None = None) -> Ratings:
        """Elo over all of them, or over those of a map."""
        there = [(meeting, row) for meeting, row in self.rows.items() if scenario in (None, meeting.scenario)]
        return elo_ratings([_pairing(meeting, row) for meeting, row in there])

    def win_rate(self, name: str, *camps: str) -> Estimate:
        """Win rate of a player over all its games in these camps, in 0..1."""
        rows = [
            row[camp]
            for meeting, row in self.rows.items()
            for camp in camps
            if getattr(meeting, camp) == name
        ]
        return wilson(sum(row["wins"] + row["draws"] / 2 for row in rows), sum(row["games"] for row in rows))


def _pairing(meeting: Meeting, row: Mapping[str, Any]) -> Pairing:
    red = row["red"]
    score = red["wins"] + red["draws"] / 2
    return Pairing(**asdict(meeting), games=red["games"], score=score)


def single_round_robin(
    names: Sequence[str], scenarios: Iterable[str], *, mirror: bool = False
) -> list[Meeting]:
    """Every player as red against every other as blue, on every map.

    Args:
        names: of the players.
        scenarios: names or paths.
        mirror: each also meets itself.
    """
    return [
        Meeting(red=red, blue=blue, scenario=scenario)
        for scenario in scenarios
        for red in names
        for blue in names
        if mirror or red != blue
    ]


def play_meetings(
    meetings: Sequence[Meeting],
    reds: Mapping[str, object],
    blues: Mapping[str, object],
    evaluation: Evaluation,
    folder: Path,
    *,
    jobs: int = 1,
) -> Table:
    """Play what has no file yet, and read all of them.

    Args:
        meetings: matches to play.
        reds: players by name: bots' names, folders, policies, models.
        blues: likewise.
        evaluation: games, seed, purpose and so on; the scenario is each meeting's, and a policy decides as often as it
            was trained to.
        folder: gets a file a match; who plays there again, goes on.
        jobs: matches side by side.

    Raises:
        FileFormatError: a file of this name is of another match: other players, terms, rules.
        BusyError: another process plays there.
    """
    matches = _matches(meetings, reds, blues, evaluation, folder)
    missing = [match for match in matches.values() if not match.is_played()]
    if missing:
        with holding(folder, "tournament"):
            run_jobs(play, missing, jobs, "match", leaves=lambda match: [match.path])
    return Table({meeting: match.read() for meeting, match in matches.items()})


def _matches(
    meetings: Iterable[Meeting],
    reds: Mapping[str, object],
    blues: Mapping[str, object],
    evaluation: Evaluation,
    folder: Path,
) -> dict[Meeting, Match]:
    """Jobs of meetings; what lies in files is named so that it travels."""
    meetings = list(meetings)
    hows = {
        name: replace(evaluation, terms=replace(evaluation.terms, scenario=at_hand(name)))
        for name in {meeting.scenario for meeting in meetings}
    }
    return {
        one: Match(one, as_place(reds[one.red]), as_place(blues[one.blue]), hows[one.scenario], folder)
        for one in meetings
    }


def pack(table: Table, path: Path) -> None:
    """Write all matches of a table into one file, a line each, that `unpack` takes apart."""
    write_entries(path, {meeting.file: row for meeting, row in table.rows.items()})


def unpack(path: Path, folder: Path) -> None:
    """Write the matches of a packed file into a folder, where they are missing; what they say is checked as they are read.

    Raises:
        FileFormatError: the file is broken, or a name in it is no match's.
    """
    rows = read_json(path, "matches") if path.exists() else {}
    for name, row in rows.items():
        if Path(name).name != name or Path(name).suffix != ".json" or not isinstance(row, dict):
            raise FileFormatError(path, name[:60], found=repr(row)[:60], expected="a match")
        if not (folder / name).exists():
            folder.mkdir(parents=True, exist_ok=True)
            write_json(folder / name, row)


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What a match's file says of one camp."""

    player: str
    games: int
    wins: int
    draws: int
    losses: int
    win_rate: float
    win_rate_interval: tuple[float, float]
    mean_margin: float
    mean_margin_interval: tuple[float, float]
    points_held: tuple[float, ...]


@dataclass(frozen=True)
class Match:
    """One job: everything that a match needs, and where its file goes."""

    meeting: Meeting
    red: object
    blue: object
    evaluation: Evaluation  # on the meeting's scenario
    folder: Path

    @property
    def path(self) -> Path:
        """Its file."""
        return self.folder / self.meeting.file

    @property
    def replay(self) -> Path:
        """File of a game of it."""
        return self.folder / f"{self.meeting.stem}.hwr"

    def is_played(self) -> bool:
        """The file is there; `read` says whether it is of this match."""
        return self.path.is_file()

    def head(self) -> dict[str, Any]:
        """What the result depends on."""
        how, terms = self.evaluation, self.evaluation.terms
        return {
            "format": FORMAT,
            "terms": {
                "games": how.games,
                "seed": how.seed,
                "purpose": how.purpose.name,
                "decision_ticks": list(self.decision_ticks),
                "spots": terms.spots,
                "early": terms.decisions == "event",
            },
            "players": {"red": fingerprint(self.red), "blue": fingerprint(self.blue)},
            **provenance(terms.scenario),
        }

    @property
    def decision_ticks(self) -> tuple[int, int]:
        """Between decisions of red and of blue: as they were trained."""
        red, blue = (trained_terms(player, self.evaluation.terms) for player in (self.red, self.blue))
        return red.decision_ticks, blue.decision_ticks

    def read(self) -> dict[str, Any]:
        """Read the file of this match.

        Raises:
            FileFormatError: it is broken, or of another match.
        """
        row = read_json(self.path, "a match")
        for key, value in self.head().items():
            found = row.get(key)
            if key != "software" and _as_text(found) != _as_text(value):  # 0 is not false
                raise FileFormatError(
                    self.path, key, found=str(found), expected=f"{value}; or choose another folder"
                )
        self._check_figures(row)
        if MEDIAN in row and not (type(row[MEDIAN]) is int and 0 <= row[MEDIAN] < self.evaluation.games):
            self._fail(MEDIAN, row[MEDIAN], f"a whole number from 0 to {self.evaluation.games - 1}")
        return row

    def _check_figures(self, row: Mapping[str, Any]) -> None:
        """What it says of the games is of this match, and adds up."""
        games = row.get("red_games")
        if (
            not isinstance(games, str)
            or len(games) != self.evaluation.games
            or set(games) - set(LETTERS.values())
        ):
            self._fail(
                "red_games", games, f"{self.evaluation.games} letters of {', '.join(LETTERS.values())}"
            )
        if type(row.get("seed")) is not int or row["seed"] != self.evaluation.seed:
            self._fail("seed", row.get("seed"), f"{self.evaluation.seed}")
        won, drawn, lost = (games.count(letter) for letter in LETTERS.values())
        for camp, wins, losses in (("red", won, lost), ("blue", lost, won)):
            figures = Figures(**read_fields(Figures, row.get(camp), self.path, place=camp, whole=True))
            counted = (getattr(self.meeting, camp), len(games), wins, drawn, losses)
            rate = wilson(wins + drawn / 2, len(games))
            found = (figures.player, figures.games, figures.wins, figures.draws, figures.losses)
            if found != counted:
                self._fail(camp, found, f"{counted}, by red_games")
            for name, value in (
                ("win_rate", rate.value),
                ("win_rate_interval", (rate.low, rate.high)),
            ):
                if not np.allclose(getattr(figures, name), value, rtol=0.0, atol=1e-9):
                    self._fail(f"{camp}.{name}", getattr(figures, name), f"{value}, by red_games")
            low, high = figures.mean_margin_interval
            if not low <= figures.mean_margin <= high:
                self._fail(f"{camp}.mean_margin", figures.mean_margin, "a number within its interval")
            if not np.isclose(sum(figures.points_held), 1.0) or min(figures.points_held) < 0.0:
                self._fail(f"{camp}.points_held", figures.points_held, "shares that add up to 1")

    def _fail(self, place: str, found: object, expected: str) -> NoReturn:
        raise FileFormatError(self.path, place, found=repr(found), expected=expected)


def play(match: Match) -> None:
    """Play a match and leave its file: a function of `match` alone, in any process."""
    match = replace(match, red=make_player(match.red), blue=make_player(match.blue))  # a folder is read once
    meeting = match.meeting
    result = match.evaluation.play(match.red, match.blue, match.decision_ticks)
    named = replace(result, red_name=meeting.red, blue_name=meeting.blue)
    games = "".join(LETTERS[score] for score in result.red.scores)
    row = {**named.summary(), **match.head(), "red_games": games, MEDIAN: median_game(result.red.margins)}
    write_json(match.path, row)


def median_game(margins: NDArray[np.float64]) -> int:
    """Number of the game that half of the games surpass by margin: what a match is like. Of equal ones it is the first.

    Example:
        >>> import numpy as np
        >>> median_game(np.array([-200.0, 30.0, 10.0, 90.0]))
        2
    """
    return int(np.flatnonzero(margins == np.sort(margins)[(len(margins) - 1) // 2])[0])


def record_medians(
    table: Table,
    reds: Mapping[str, object],
    blues: Mapping[str, object],
    evaluation: Evaluation,
    folder: Path,
    *,
    jobs: int = 1,
    command: str | None = None,
) -> None:
    """Write down the median game of each match of a table into a folder, where it is missing.

    Args:
        table: from `play_meetings`; matches that an earlier version played do not say which game that is, and have none.
        reds, blues, evaluation, jobs: as there.
        folder: gets `SCENARIO~RED~BLUE.hwr`.
        command: what made them, as one would type it.
    """
    rows = {meeting: row for meeting, row in table.rows.items() if MEDIAN in row}
    matches = _matches(rows, reds, blues, evaluation, folder)
    games = [(match, int(rows[meeting][MEDIAN]), command) for meeting, match in matches.items()]
    missing = [one for one in games if not _is_recorded(*one[:2])]
    run_jobs(_record, missing, jobs, "game", leaves=lambda job: [job[0].replay])


def _is_recorded(match: Match, game: int) -> bool:
    """Whether the folder has this game of these players; of another one, or a broken file, it is made anew."""
    try:
        replay = Replay.load(match.replay)
    except (FileFormatError, OSError):
        return False
    seed = game_seed(seed_for(match.evaluation.purpose, match.evaluation.seed), game)
    seats = (make_player(match.red), make_player(match.blue))
    hashes = [bots_hash() if isinstance(one, BotPlayer) else getattr(one, "sha256", None) for one in seats]
    found = [player.get("hash") for player in replay.head.get("players", {}).values()]
    return replay.seed == seed and found == hashes


def _record(job: tuple[Match, int, str | None]) -> None:
    match, game, command = job
    names = match.meeting.red, match.meeting.blue
    replay = match.evaluation.record(match.red, match.blue, game, match.decision_ticks, names, command)
    replay.save(match.replay)


def fingerprint(player: object) -> str:
    """What tells a player from others of its name: the hash of its weights, or of the bots; else its type."""
    seat = make_player(player)
    if isinstance(seat, BotPlayer):
        drawn = as_member(seat.name)[0] in FAMILIES
        return f"{seat.name} {drawn_hash() if drawn else bots_hash()}"
    return seat.sha256 if isinstance(seat, FrozenPolicy) else type(seat).__name__


def _as_text(value: object) -> str:
    return json.dumps(value, sort_keys=True)
