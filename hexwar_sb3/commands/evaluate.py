"""`hexwar evaluate` and `hexwar match`: figures with intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from hexwar_sb3.checks import check_whole
from hexwar_sb3.commands.output import (
    COUNTS,
    compile_first,
    games_bar,
    panel_table,
    print_json,
    result_cells,
    table,
    typed,
)
from hexwar_sb3.commands.settings import AsTrained, ConstantPlans, Games, Json, Seed
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.players.terms import DECISION_TICKS, Terms

PLAYER = "a bot's name, a run folder or a policy folder"


@dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Measure a player against a panel of opponents, in both colours, beside constant plans.

    A policy plays as it was trained: the same cells for its tasks, the same decision points.
    """

    player: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="PLAYER", help=PLAYER)]
    opponents: tuple[str, ...] = ("MA1", "MA2")  # bots' names or folders
    # name of a built-in scenario, NAME@SEED for one like it, or path of a file
    scenario: AsTrained[str] = None
    side: AsTrained[Literal["red", "blue", "both"]] = None  # camps that the player takes
    games: Games = 2000
    seed: Seed = 0
    decision_ticks: AsTrained[int] = None  # ticks between two decisions
    constant_plans: ConstantPlans = True
    json: Json = False

    def run(self) -> int:
        """Play, then print the table."""
        from hexwar_sb3.evaluation.matches import player_name
        from hexwar_sb3.evaluation.panel import CONSTANT_PLANS, play_panel
        from hexwar_sb3.evaluation.provenance import provenance
        from hexwar_sb3.players.terms import CAMPS_OF, trained_camps, trained_terms

        if not self.opponents:
            raise ConfigError("name at least one opponent")
        given: dict[str, Any] = {"scenario": self.scenario, "decision_ticks": self.decision_ticks}
        terms = replace(
            trained_terms(self.player), **{name: value for name, value in given.items() if value is not None}
        )
        camps = CAMPS_OF[self.side] if self.side else trained_camps(self.player)
        how = Evaluation(terms=terms, games=self.games, seed=self.seed, camps=camps)
        compile_first(self.player, *self.opponents, scenario=terms.scenario)
        how.check_fit([self.player], camps)
        how.check_opponents(self.opponents)
        players = [self.player, *(CONSTANT_PLANS if self.constant_plans else ())]
        with games_bar(len(players) * len(self.opponents) * len(camps) * self.games) as progress:
            panels = [
                play_panel(player, self.opponents, how, name=player_name(player), progress=progress)
                for player in players
            ]
        rows = [row for panel in panels for row in panel.summary()]
        if self.json:
            print_json({"seed": self.seed, **provenance(terms.scenario), "rows": rows})
        else:
            print(panel_table(rows))
        return 0


@dataclass(frozen=True, kw_only=True)
class Match:
    """Play one pairing many times."""

    red: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="RED", help=PLAYER)]
    blue: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="BLUE", help=PLAYER)]
    # name of a built-in scenario, NAME@SEED for one like it, or path of a file
    scenario: AsTrained[str] = None
    games: Games = 2000
    seed: Seed = 0
    decision_ticks: AsTrained[int] = None  # ticks between two decisions
    record: Path | None = None  # file (*.hwr) that gets a game, or folder that gets several, and their page
    record_games: tuple[int, ...] = (0,)  # which, by their numbers from 0
    json: Json = False

    def run(self) -> int:
        """Play, then print what both camps reached."""
        from hexwar_sb3.evaluation.provenance import provenance

        terms, ticks = self._terms()
        how = Evaluation(terms=terms, games=self.games, seed=self.seed)
        self._check_record()
        compile_first(self.red, self.blue, scenario=terms.scenario)
        match = how.play(self.red, self.blue, ticks)
        if self.record is not None:
            self._record(how, self.record, ticks)
        summary = match.summary()
        if self.json:
            print_json({**summary, **provenance(terms.scenario)})
        else:
            rows = [[camp, summary[camp]["player"], *result_cells(summary[camp])] for camp in ("red", "blue")]
            print(table(("camp", "player", *COUNTS), rows))
        return 0

    def _terms(self) -> tuple[Terms, tuple[int, int]]:
        """Terms of the games, of red's training where it says any, else of blue's; ticks between decisions of each."""
        from hexwar_sb3.players.terms import trained_terms

        blue = trained_terms(self.blue)
        red = trained_terms(self.red, replace(blue, decision_ticks=DECISION_TICKS))
        given = self.decision_ticks
        own, its = (each.decision_ticks if given is None else given for each in (red, blue))
        scenario = red.scenario if self.scenario is None else self.scenario
        return replace(red, scenario=scenario, decision_ticks=own), (own, its)

    def _check_record(self) -> None:
        for number in self.record_games:
            check_whole("record_games", number, least=0, most=self.games - 1)
        if self.record is None:
            return
        if self._is_folder(self.record):
            if self.record.exists() and not self.record.is_dir():
                raise ConfigError(
                    f"--record {self.record} is a file, and no replay's; name a folder, or a file.hwr"
                )
            return
        if len(self.record_games) != 1:
            raise ConfigError(f"--record {self.record} is a file for one game; name a folder for several")

    def _record(self, how: Evaluation, place: Path, ticks: tuple[int, int]) -> None:
        from hexwar_sb3.commands.albums import save_at_end
        from hexwar_sb3.viewer.album import Album, Clip

        for number in self.record_games:
            replay = how.record(self.red, self.blue, number, ticks, command=typed())
            replay.save(place / f"game_{number:06d}.hwr" if self._is_folder(place) else place)
        if self._is_folder(place):
            names = {f"game {number}": place / f"game_{number:06d}.hwr" for number in self.record_games}
            clips = [Clip(path=path, name=name) for name, path in names.items()]
            title = f"{Path(self.red).name} against {Path(self.blue).name}, seed {self.seed}"
            save_at_end(lambda: Album(title=title, clips=clips), place / "games.html")

    @staticmethod
    def _is_folder(path: Path) -> bool:
        """A folder that is there, or a name without a suffix."""
        return path.is_dir() or not path.suffix
