"""`hexwar stats`: how a player plays, over recorded or fresh games."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from hexwar_sb3.commands.output import as_json, compile_first, print_json, table
from hexwar_sb3.commands.run_folder import write_text
from hexwar_sb3.commands.settings import Json, Seed, check_jobs
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.player import POLICY_FILE

if TYPE_CHECKING:
    from hexwar_sb3.engine.replay import Replay
    from hexwar_sb3.evaluation.matches import Evaluation
    from hexwar_sb3.evaluation.play_stats import PlayStats

WHAT = "a player (a bot's name, a run folder or a policy folder), or replays (*.hwr) and folders of them"
WhoPlays = Annotated[
    str | None,
    tyro.conf.arg(
        help="whose play is counted in replays, by its name there",
        help_behavior_hint="(default: who is in all of them)",
    ),
]
CHUNK = 25  # games of a job
WORDS = {True: "holds", False: "does not hold", None: "open"}


@dataclass(frozen=True, kw_only=True)
class Stats:
    """Count how a player plays: tasks by phase and piece, targets, moves, places; and which of the paper's claims hold."""

    what: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="PLAYER|REPLAY...", help=WHAT)
    ]
    opponents: tuple[str, ...] = ("MA1", "MA2")  # of a player's games
    games: int = 500  # of a player, an opponent and colour
    seed: Seed = 0
    player: WhoPlays = None
    jobs: int = 1  # side by side
    output: Path | None = None  # folder that gets stats.txt, stats.json and pictures (PDF, SVG, PNG)
    json: Json = False

    def run(self) -> int:
        """Count, then print and draw."""
        from hexwar_sb3.maps.files import scenario_from_document

        check_jobs("jobs", self.jobs)
        found = {one: list(_replays(one)) for one in self.what}
        paths = [path for one in found.values() for path in one]
        if paths and not all(found.values()):
            raise ConfigError("name either one player or replays, not both")
        if not paths and len(self.what) != 1:
            raise ConfigError("name one player, or replays (*.hwr)")
        name, stats, document = self._of_replays(paths) if paths else self._of_player(self.what[0])
        text = in_words(stats, name)
        if self.output is not None:
            from hexwar_sb3.evaluation.play_stats_picture import draw_stats

            self.output.mkdir(parents=True, exist_ok=True)
            write_text(self.output / "stats.txt", text + "\n")
            write_text(self.output / "stats.json", as_json({"player": name, **stats.as_dict()}) + "\n")
            draw_stats(stats, scenario_from_document(document, name), self.output, player=name)
        if self.json:
            print_json({"player": name, **stats.as_dict()})
        else:
            print(text)
        return 0

    def _of_replays(self, paths: Sequence[Path]) -> tuple[str, PlayStats, object]:
        from hexwar_sb3.engine.replay import Replay
        from hexwar_sb3.evaluation.play_stats import PlayStats

        replays = [Replay.load(path) for path in paths]
        if len({replay.head["scenario"].get("hash") for replay in replays}) > 1:
            raise ConfigError("the replays are of several scenarios; count one at a time")
        name, stats, hashes = self.player or _shared_name(replays), PlayStats(), set()
        for replay in replays:
            for camp, player in replay.head.get("players", {}).items():
                if player["name"] == name:
                    stats.add(replay, camp)
                    hashes.add(player.get("hash"))
        if not stats.games:
            raise ConfigError(f"no replay has a player called {name!r}")
        if len(hashes) > 1:
            raise ConfigError(
                f"{len(hashes)} players are called {name!r}; count the replays of each by themselves"
            )
        return name, stats, replays[0].head["scenario"]

    def _of_player(self, player: str) -> tuple[str, PlayStats, object]:
        from hexwar_sb3.engine.world import load_world
        from hexwar_sb3.evaluation.jobs import run_jobs
        from hexwar_sb3.evaluation.matches import Evaluation, player_name
        from hexwar_sb3.evaluation.parcels import as_place, at_hand
        from hexwar_sb3.evaluation.play_stats import PlayStats
        from hexwar_sb3.maps.scenario_file import scenario_document
        from hexwar_sb3.players.terms import trained_terms

        terms = trained_terms(player)
        how = Evaluation(terms=terms, games=self.games, seed=self.seed)
        compile_first(player, *self.opponents, scenario=terms.scenario)
        how.check_fit([player])
        how.check_opponents(self.opponents)
        at_work = replace(how, terms=replace(terms, scenario=at_hand(terms.scenario)))
        specs = [
            _Chunk(
                as_place(player),
                as_place(opponent),
                camp,
                at_work,
                range(start, min(start + CHUNK, self.games)),
            )
            for opponent in self.opponents
            for camp in how.camps
            for start in range(0, self.games, CHUNK)
        ]
        stats = PlayStats()
        for part in run_jobs(_count, specs, self.jobs, f"{CHUNK} games"):
            stats.merge(part)
        return player_name(player), stats, scenario_document(load_world(terms.scenario).scenario)


@dataclass(frozen=True)
class _Chunk:
    """Games of one job."""

    player: object
    opponent: object
    camp: str
    how: Evaluation
    games: range


def _count(chunk: _Chunk) -> PlayStats:
    from hexwar_sb3.evaluation.play_stats import PlayStats
    from hexwar_sb3.players.terms import trained_terms

    stats, is_red = PlayStats(), chunk.camp == "red"
    red, blue = (chunk.player, chunk.opponent) if is_red else (chunk.opponent, chunk.player)
    own = chunk.how.terms.decision_ticks
    its = trained_terms(chunk.opponent, chunk.how.terms).decision_ticks  # it decides as it was trained
    for game in chunk.games:
        stats.add(chunk.how.record(red, blue, game, (own, its) if is_red else (its, own)), chunk.camp)
    return stats


def _replays(what: str) -> Iterator[Path]:
    """A replay, or those of a folder; the folder of a run or of a policy is a player."""
    from hexwar_sb3.engine.replay_file import SUFFIX, replays_in

    path = Path(what)
    if path.suffix == SUFFIX:
        yield path
    elif path.is_dir() and not any((one / POLICY_FILE).is_file() for one in (path, path / "policy")):
        yield from replays_in(path)


def _shared_name(replays: Sequence[Replay]) -> str:
    names = [{player["name"] for player in one.head.get("players", {}).values()} for one in replays]
    shared = sorted(set.intersection(*names))
    if len(shared) != 1:
        found = ", ".join(sorted(set.union(*names)))
        raise ConfigError(f"say whose play is counted, --player NAME: the replays have {found}")
    return shared[0]


def in_words(stats: PlayStats, name: str) -> str:
    """Tables: tasks, targets, moves, and the paper's claims."""
    from hexwar_sb3.evaluation.play_stats import GRID, PHASES, PIECE, TYPES

    tasks = []
    for phase in PHASES:
        for kind in TYPES:
            counts = Counter(
                {k: n for (p, t, k), n in stats.tasks.items() if (p, t) == (phase, kind) and k != "stop"}
            )
            if counts:
                found = stats.decisions(phase, kind)
                shares = [f"{100 * found[group] / counts.total():.1f}" for group in (GRID, PIECE)]
                most = ", ".join(
                    f"{word} {100 * n / counts.total():.0f} %" for word, n in counts.most_common(3)
                )
                tasks.append([phase, kind, f"{counts.total():,}", *shares, most])
    shots = []
    for shooter in TYPES:
        total = sum(stats.targets[shooter, target] for target in TYPES)
        if total:
            cells = [
                f"{100 * stats.targets[shooter, t] / total:.0f} ({100 * stats.available.get((shooter, t), 0) / total:.0f})"
                for t in TYPES
            ]
            shots.append([shooter, f"{total:,}", *cells])
    moves = [
        [kind, f"{stats.moves[kind]:,}", f"{100 * stats.agreeing[kind] / stats.moves[kind]:.1f}"]
        for kind in TYPES
        if stats.moves[kind]
    ]
    claims = [
        [words, found.percent() if "targets" not in words else str(found), WORDS[holds]]
        for words, found, holds in stats.claims()
    ]
    return "\n\n".join(
        (
            f"How {name} plays: {stats.games:,} games",
            table(("phase", "piece", "decisions", "grid tasks, %", "piece tasks, %", "most often"), tasks),
            "targets in the first half of the game, % of the shots (in brackets: of what could be fired at)\n"
            + table(("shooter", "shots", *TYPES), shots),
            table(("piece", "hops to a cell", "as the heuristic's, %"), moves),
            table(("what the paper says of its CAI", "here, 95 % over games", ""), claims),
        )
    )
