"""`hexwar tournament`: players meet each other, in both colours, on every map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from hexwar_sb3.commands.output import as_json, compile_first, print_json, table, typed
from hexwar_sb3.commands.run_folder import write_text
from hexwar_sb3.commands.settings import Cluster, Games, Json, Seed, check_jobs, check_name
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation

if TYPE_CHECKING:
    from hexwar_sb3.evaluation.intervals import Estimate
    from hexwar_sb3.evaluation.tournament import Table

PAGE = "league.html"  # heat map and median games, to click through
PLAYERS = "bots' names, run folders or policy folders; NAME=PLAYER calls it NAME"


@dataclass(frozen=True, kw_only=True)
class Tournament:
    """Let every player meet every other in both colours; what was played is kept, so the same command goes on.

    A policy decides as often as it was trained to.
    """

    players: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="PLAYER...", help=PLAYERS)
    ]
    # names of built-in scenarios, NAME@SEED for one like it, or paths of files
    scenarios: tuple[str, ...] = ("plain",)
    games: Games = 200
    seed: Seed = 0
    mirror: bool = False  # each player also meets itself
    jobs: int | None = None  # matches side by side; else 1, or the cluster's processors
    cluster: Cluster = None
    record: bool = True  # write down the median game of each match
    # folder: matches/, games/, league.html, table.txt, table.json, tournament.png
    output: Path = Path("tournament")
    json: Json = False

    def run(self) -> int:
        """Play what is missing, then print and draw."""
        from hexwar_sb3.commands.albums import album_of, save_at_end
        from hexwar_sb3.evaluation.cluster import working_on
        from hexwar_sb3.evaluation.tournament import play_meetings, record_medians, single_round_robin
        from hexwar_sb3.evaluation.tournament_picture import draw_tournament
        from hexwar_sb3.folders import holding

        players = named(self.players)
        if len(players) < 2 - self.mirror or not self.scenarios:
            raise ConfigError("a tournament needs two players and a scenario")
        check_jobs("jobs", self.jobs)
        if len({Path(scenario).name for scenario in self.scenarios}) < len(self.scenarios):
            raise ConfigError(f"two scenarios have one name: {', '.join(self.scenarios)}")
        how = self._evaluation(players)
        for scenario in self.scenarios:
            compile_first(*players.values(), scenario=scenario)
            replace(how, terms=replace(how.terms, scenario=scenario)).check_fit(players.values())
        meetings = single_round_robin(list(players), self.scenarios, mirror=self.mirror)
        with holding(self.output, "tournament"), working_on(self.cluster, self.jobs) as jobs:
            found = play_meetings(meetings, players, players, how, self.output / "matches", jobs=jobs)
            figures = {"players": players, "elo": _elo(found), "matches": list(found.rows.values())}
            write_text(self.output / "table.json", as_json(figures) + "\n")
            text = in_words(found, list(players))
            write_text(self.output / "table.txt", text + "\n")
            draw_tournament(found, list(players), self.output / "tournament.png")
            if self.record:
                record_medians(
                    found, players, players, how, self.output / "games", jobs=jobs, command=typed()
                )
            save_at_end(lambda: album_of([self.output]), self.output / PAGE, jobs)
        if self.json:
            print_json(figures)
        else:
            print(text, f"\npicture: {self.output / 'tournament.png'}\npage: {self.output / PAGE}")
        return 0

    def _evaluation(self, players: Mapping[str, str]) -> Evaluation:
        """How all matches are played.

        Raises:
            ConfigError: two policies were trained with other task sets or decision points.
        """
        from hexwar_sb3.bots.registry import is_bot
        from hexwar_sb3.evaluation.matches import Evaluation
        from hexwar_sb3.players.terms import USUAL, trained_terms

        trained = {name: trained_terms(player) for name, player in players.items() if not is_bot(player)}
        shared = next(iter(trained.values()), USUAL)
        for name, own in trained.items():
            for key in ("spots", "decisions"):
                if getattr(own, key) != getattr(shared, key):
                    raise ConfigError(
                        f"{name} was trained with {key} {getattr(own, key)}, others with {getattr(shared, key)}:"
                        " they cannot meet"
                    )
        terms = replace(USUAL, spots=shared.spots, decisions=shared.decisions)
        return Evaluation(terms=terms, games=self.games, seed=self.seed)


def named(players: tuple[str, ...]) -> dict[str, str]:
    """Players by name: what is left of "=", or the path's last parts, as many as it takes to tell them apart.

    Raises:
        ConfigError: a name is given twice, or no name for a file.

    Example:
        >>> named(("MA1", "runs/a_1/policy", "runs/b_1/policy", "best=runs/c_1"))
        {'MA1': 'MA1', 'a_1-policy': 'runs/a_1/policy', 'b_1-policy': 'runs/b_1/policy', 'best': 'runs/c_1'}
    """
    paths = [player.partition("=")[2] or player for player in players]
    parts = [[part for part in Path(path).parts if part not in ("/", ".", "..")] or [path] for path in paths]
    found: dict[str, str] = {}
    for player, path, words in zip(players, paths, parts, strict=True):
        depth = next(
            (d for d in range(1, len(words)) if sum(other[-d:] == words[-d:] for other in parts) == 1),
            len(words),
        )
        name = player.partition("=")[0] if "=" in player else "-".join(words[-depth:])
        check_name("name of a player", name)
        if name in found:
            raise ConfigError(f"two players are called {name}; NAME=PLAYER gives another name")
        found[name] = path
    return found


def in_words(found: Table, names: list[str]) -> str:
    """Ratings, and a table a map."""
    from hexwar_sb3.evaluation.tournament import Meeting

    elo = found.ratings()
    order = sorted(names, key=lambda name: -elo.players[name].value)
    each = [found.ratings(scenario) for scenario in found.scenarios] if len(found.scenarios) > 1 else []
    heads = (
        "player",
        "Elo",
        *(f"on {Path(name).name}" for name in found.scenarios[: len(each)]),
        "as red, %",
        "as blue, %",
    )
    rows = [
        [
            name,
            *(_whole(ratings.players[name]) for ratings in (elo, *each)),
            *(found.win_rate(name, camp).percent() for camp in ("red", "blue")),
        ]
        for name in order
    ]
    parts = [table(heads, rows)]
    for scenario, seat in elo.red_seat.items():
        cells = [
            [red, *(_cell(found.rows.get(Meeting(red=red, blue=blue, scenario=scenario))) for blue in order)]
            for red in order
        ]
        head = f'"{Path(scenario).name}": win rate of red (rows) against blue (columns), %; red\'s seat is worth {_whole(seat)} Elo'
        parts.append(f"{head}\n{table(('red', *order), cells)}")
    return "\n\n".join(parts)


def _whole(elo: Estimate) -> str:
    return f"{elo.value:.0f} [{elo.low:.0f}, {elo.high:.0f}]"


def _cell(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return "-"
    low, high = row["red"]["win_rate_interval"]
    return f"{100 * row['red']['win_rate']:.1f} [{100 * low:.1f}, {100 * high:.1f}]"


def _elo(found: Table) -> dict[str, Any]:
    ratings = found.ratings()
    kinds = {"players": ratings.players, "red_seat": ratings.red_seat}
    return {
        kind: {name: [e.value, e.low, e.high] for name, e in shown.items()} for kind, shown in kinds.items()
    }
