"""`hexwar hotspots`: the cells that tasks lead to, from visits in recorded or fresh games."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from hexwar_sb3.commands.output import compile_first, games_bar, print_json, table
from hexwar_sb3.commands.settings import Json, ScenarioName, Seed
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.terms import Terms

if TYPE_CHECKING:
    from hexwar_sb3.engine.replay import Replay
    from hexwar_sb3.tasks.hotspots import VisitCount
    from hexwar_sb3.tasks.spots_file import HotSpots

HEADS = ("camp", "rank", "cell", "visits")
_NAMED_PAIRS = 4  # pairs of players that the source of counted replays names


@dataclass(frozen=True, kw_only=True)
class Hotspots:
    """Count where pieces stay in games; choose the cells G^L(k), their hull, and the map's walls."""

    files: tyro.conf.Positional[tuple[Path, ...]] = ()  # replays (*.hwr) or folders of them; or --games
    games: int = 0  # games to play and count, with red and blue as named, and as many the other way round
    scenario: ScenarioName = "plain"  # of --games
    red: str = "MA1"  # player of --games: a bot's name, a run folder or a policy folder
    blue: str = "MA2"  # its opponent, named likewise
    seed: Seed = 0  # of --games, in the range of training games
    k: int | None = None  # spots beside the control points; else 6, or as many as were visited
    out: Path | None = None  # file (*.json) that gets spots, hull, visits and walls
    picture: Path | None = None  # picture of them (png, svg or pdf)
    json: Json = False

    def run(self) -> int:
        """Count, print the spots, and write what was asked for."""
        from hexwar_sb3.tasks.hotspots import hot_spots
        from hexwar_sb3.tasks.picture import save_spots_picture

        self._check()
        count = self._counted()
        spots = hot_spots(count.world, count.visits, self.k, source=self._source(count))
        if self.out is not None:
            spots.save(self.out)
            print(f"spots: {self.out}", file=sys.stderr)
        if self.picture is not None:
            save_spots_picture(spots, count.world.scenario, self.picture)
            print(f"picture: {self.picture}", file=sys.stderr)
        if self.json:
            print_json(spots.document())
        else:
            print(table(HEADS, list(rows(spots))))
            print(f"{len(spots.walls)} walls; {spots.source}")
        return 0

    def _check(self) -> None:
        """Meet a mistake before the games are played."""
        from hexwar_sb3.evaluation.seeds import Purpose, seed_for
        from hexwar_sb3.tasks.picture import check_picture

        if bool(self.files) == bool(self.games):
            raise ConfigError("name replays or folders of them, or give --games, not both")
        if self.games < 0:
            raise ConfigError(f"games must be at least 1, got {self.games}")
        seed_for(Purpose.TRAINING, self.seed)
        if self.out is not None and (self.out.is_dir() or self.out.suffix != ".json"):
            raise ConfigError(f"--out {self.out} must be a file's name that ends in .json")
        if self.picture is not None:
            check_picture(self.picture)

    def _counted(self) -> VisitCount:
        from hexwar_sb3.engine.replay import Replay
        from hexwar_sb3.engine.world import load_world
        from hexwar_sb3.tasks.hotspots import VisitCount
        from hexwar_sb3.tasks.spots import check_spots

        count = VisitCount()
        if self.games:
            if self.k is not None:
                check_spots(load_world(self.scenario), self.k)
            compile_first(self.red, self.blue, scenario=self.scenario)
            with games_bar(len(self._pairs()) * self.games) as progress:
                for replay in self._played():
                    count.add(replay)
                    progress(1)
        else:
            for path in self._paths():
                count.add(Replay.load(path))
        return count

    def _pairs(self) -> list[tuple[str, str]]:
        """Both pairings, one if a player meets itself."""
        return list(dict.fromkeys([(self.red, self.blue), (self.blue, self.red)]))

    def _played(self) -> Iterator[Replay]:
        from hexwar_sb3.evaluation.seeds import Purpose, seed_for
        from hexwar_sb3.play.recording import record_game

        seed = seed_for(Purpose.TRAINING, self.seed)
        for red, blue in self._pairs():
            for episode in range(self.games):
                yield record_game(red, blue, Terms(scenario=self.scenario), seed, episode=episode)

    def _paths(self) -> Iterator[Path]:
        from hexwar_sb3.engine.replay_file import replays_of

        for path in self.files:
            yield from replays_of(path)

    def _source(self, count: VisitCount) -> str:
        """Whose games were counted, and the command that counts them again."""
        from hexwar_sb3.tasks.spots_file import SOURCE_CHARACTERS

        pairs = [f"{games} of {red} against {blue}" for (red, blue), games in count.players.most_common()]
        more = ", ..." if len(pairs) > _NAMED_PAIRS else ""
        text = f"{self._command()}: {count.replays} games, {', '.join(pairs[:_NAMED_PAIRS])}{more}"
        return text[:SOURCE_CHARACTERS]

    def _command(self) -> str:
        if not self.games:
            return shlex.join(["hexwar", "hotspots", *(path.name for path in self.files), "--k", str(self.k)])
        names = ("games", "scenario", "red", "blue", "seed", "k")
        flags = [word for name in names for word in (f"--{name}", str(getattr(self, name)))]
        return shlex.join(["hexwar", "hotspots", *flags])


def rows(spots: HotSpots) -> Iterator[list[str]]:
    """Rows of the table: the first k cells of each camp."""
    for camp, own in zip(("red", "blue"), spots.camps, strict=True):
        for rank, cell in enumerate(own.cells[: spots.k], start=1):
            yield [camp, str(rank), spots.hexmap.cell_name(cell), str(own.visits[cell])]
