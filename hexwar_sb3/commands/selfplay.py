"""`hexwar selfplay`: grouped self-play from the models of earlier trainings (Fig. 6)."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from hexwar_sb3.commands.output import compile_first, print_json, table, typed
from hexwar_sb3.commands.settings import Cluster, Json, ScenarioName, Seed, check_jobs
from hexwar_sb3.evaluation.opponents import broad_mixture

if TYPE_CHECKING:
    from hexwar_sb3.league.league import League

STARTERS = "run folders or policy folders to begin with; NAME=FOLDER calls it NAME"
INTERRUPTED = 130  # exit code after Ctrl-C


@dataclass(frozen=True, kw_only=True)
class SelfPlay:
    """Let red and blue models train in groups, meet in a round robin, and keep the best; again and again.

    The folder is the state: the same command goes on where it was stopped.
    """

    starters: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="POLICY...", help=STARTERS)
    ] = ()
    output: Path = Path("league")  # folder of the league
    iterations: int = 10  # of training, round robin and selection
    keep: int = 4  # models that are kept, each of which trains; if split, of each colour, and all pairs train
    split: bool = False  # red and blue models of their own, as in the paper; else each plays both camps
    games: int = 3_200  # that each model of a group learns from
    match_games: int = 100  # of each pairing in the round robin
    warm_up_games: int = 200  # of each model to begin with against each opponent, to order them
    # bots and HRL0, NAME or NAME=WEIGHT, met in training and in the round robin; else those of `hexwar train`
    opponents: tuple[str, ...] | None = None
    partner_share: float = 0.05  # of the weights, for the partners
    past_share: float = 0.05  # for the best of the iterations before
    # exponent by which those who beat the model are met more often; 0: by their weights alone
    priority: float = 1.0
    hidden: int = 128  # width of the models' networks; narrower ones are widened
    embed: int = 32  # width of a task's embedding
    scenario: ScenarioName = "plain"
    seed: Seed = 0
    jobs: int | None = None  # groups, then matches, side by side; else 1, or the cluster's processors
    cluster: Cluster = None
    json: Json = False

    def run(self) -> int:
        """Begin or go on, then print who was kept."""
        from hexwar_sb3.commands.albums import album_of, save_at_end
        from hexwar_sb3.commands.tournament import named
        from hexwar_sb3.evaluation.cluster import working_on
        from hexwar_sb3.league.league import League
        from hexwar_sb3.league.settings import LeagueSettings

        check_jobs("jobs", self.jobs)
        names = LeagueSettings.__dataclass_fields__
        own = {name: value for name, value in vars(self).items() if name in names}
        own["opponents"] = broad_mixture(self.scenario) if self.opponents is None else self.opponents
        settings = LeagueSettings(**own)
        starters = {name: policy_folder(Path(path)) for name, path in named(self.starters).items()}
        compile_first(scenario=self.scenario)
        try:
            league = League.create(self.output, settings, starters)
            with working_on(self.cluster, self.jobs) as jobs:
                league.run(jobs, after=lambda k: print(in_words(league, k), file=sys.stderr, flush=True))
                if settings.iterations:
                    league.record_games(settings.iterations, jobs, typed())
                    save_at_end(lambda: album_of([self.output]), self.output / "league.html", jobs)
        except KeyboardInterrupt:
            print("\nstopped; the same command goes on", file=sys.stderr)
            return INTERRUPTED
        last = league.kept(settings.iterations)
        champions = {camp: [str(member.folder) for member in members] for camp, members in last.items()}
        if self.json:
            print_json({"league": str(self.output), "kept": champions})
        else:
            rows = [
                [camp, str(place + 1), path]
                for camp, paths in champions.items()
                for place, path in enumerate(paths)
            ]
            print(table(("colour", "place", "policy"), rows))
        return 0


def policy_folder(path: Path) -> Path:
    """Folder of a policy: of a run, its policy/."""
    return path / "policy" if (path / "policy" / "config.json").is_file() else path


def in_words(league: League, k: int) -> str:
    """One line on an iteration: the best of each colour."""
    found = league.standings(k)
    best = (
        f"{camp} {found[camp][0]['name']} {100 * found[camp][0]['win_rate']:.1f} %"
        for camp in ("red", "blue")
    )
    return f"iteration {k}: best {', '.join(best)}"
