"""A ladder of opponents: from an untrained policy to the best one, climbed by wins, with a record in a small file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.elo import Pairing, elo_ratings
from hexwar_sb3.evaluation.intervals import Estimate
from hexwar_sb3.files import write_json
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.document import shown
from hexwar_sb3.reading import check_names, read_json
from hexwar_sb3.server.person import PERSON

SUFFIX = ".ladder.json"
FORMAT = "hexwar ladder 1"
SCORES = {"won": 1.0, "drawn": 0.5, "lost": 0.0}
Json = dict[str, Any]


@dataclass(frozen=True)
class Rung:
    """An opponent."""

    name: str
    player: str  # as `make_player` takes it


@dataclass(frozen=True, kw_only=True)
class Played:
    """A game that was played to its end."""

    rung: str
    camp: Literal["red", "blue"]  # the person's
    scenario: str
    result: Literal["won", "drawn", "lost"]
    margin: int  # the person's
    game: str  # its name


class Ladder:
    """Opponents in order, and how the person did against them.

    Args:
        rungs: the easiest first.
        file: with the games so far; it need not be there yet.

    Raises:
        ConfigError: there are no rungs.
        FileFormatError: the file is broken; says where, what was found and what was expected.
    """

    def __init__(self, rungs: Sequence[Rung], file: Path) -> None:
        if not rungs:
            raise ConfigError(f"{file}: a ladder without opponents; expected at least one")
        self.rungs, self.file = tuple(rungs), file
        self.games = _read(file) if file.exists() else []

    @property
    def at(self) -> int:
        """Number of the rung that is to be played: who wins goes up, to the last one at most."""
        rung = 0
        for game in self.games:
            rung += game.rung == self.rungs[rung].name and game.result == "won"
            rung = min(rung, len(self.rungs) - 1)
        return rung

    def rung_of(self, player: str) -> Rung:
        """The rung on which a player stands.

        Raises:
            ConfigError: none.
        """
        for rung in self.rungs:
            if rung.player == player:
                return rung
        raise ConfigError(f"{player} is on no rung of this ladder; expected one of its opponents")

    def note(self, game: Played) -> None:
        """Write down a game; the same one counts once."""
        if game.game not in {one.game for one in self.games}:
            self.games.append(game)
            self.file.parent.mkdir(parents=True, exist_ok=True)
            write_json(self.file, {"format": FORMAT, "games": [asdict(one) for one in self.games]})

    def told(self) -> Json:
        """What the page shows."""
        ratings = self._ratings()
        return {
            "rungs": [self._told(rung, ratings) for rung in self.rungs],
            "rung": self.at,
            **_shown(ratings.get(PERSON)),
        }

    def _told(self, rung: Rung, ratings: dict[str, Estimate]) -> Json:
        games = [game for game in self.games if game.rung == rung.name]
        won = sum(game.result == "won" for game in games)
        return {
            "name": rung.name,
            "won": won,
            "games": len(games),
            **_shown(ratings.get(f"rung {rung.name}")),
        }

    def _ratings(self) -> dict[str, Estimate]:
        """Elo of the person and of the opponents that it met, by these games alone."""
        return elo_ratings([_pairing(game) for game in self.games]).players if self.games else {}


def _pairing(game: Played) -> Pairing:
    score, other = SCORES[game.result], f"rung {game.rung}"
    red, blue = (PERSON, other) if game.camp == "red" else (other, PERSON)
    won = score if game.camp == "red" else 1 - score
    return Pairing(red=red, blue=blue, games=1, score=won, scenario=game.scenario)


def _shown(rating: Estimate | None) -> Json:
    if rating is None:
        return {"elo": None, "elo_range": None}
    return {"elo": round(rating.value), "elo_range": [round(rating.low), round(rating.high)]}


def _read(file: Path) -> list[Played]:
    found = read_json(file)
    check_names(found, {"format": FORMAT, "games": []}, file)
    if found.get("format") != FORMAT:
        raise FileFormatError(file, "format", found=shown(found.get("format")), expected=shown(FORMAT))
    games = found.get("games")
    if not isinstance(games, list):
        raise FileFormatError(file, "games", found=shown(games), expected="a list of games")
    return [
        Played(**read_fields(Played, game, file, place=f"games[{n}]", whole=True))
        for n, game in enumerate(games)
    ]
