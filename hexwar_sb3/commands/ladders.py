"""Ladders of opponents out of what a training or a league left."""

from __future__ import annotations

from pathlib import Path

from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.server.ladder import SUFFIX, Ladder, Rung

SNAPSHOTS = 5  # of a training, beside its beginning and its end


def open_ladder(place: Path, camp: str, folder: Path) -> Ladder:
    """The ladder of a run or a league, whose record lies in a folder.

    Args:
        place: the run's or the league's folder.
        camp: of the opponents.
        folder: where games lie.

    Raises:
        ConfigError: there are no policies.
        FileFormatError: the league or the record is broken.
    """
    rungs = _of_league(place, camp) if (place / "league.json").is_file() else _of_run(place)
    if not rungs:
        raise ConfigError(f"{place}: no policies; expected the folder of a training or of a league")
    return Ladder(rungs, folder / f"{place.resolve().name}{SUFFIX}")


def _of_run(place: Path) -> list[Rung]:
    """Untrained, some of the snapshots, and the policy that was kept."""
    run = RunFolder(place)
    snapshots = [path for path in sorted(run.snapshots.glob("*")) if path.name.isdigit() and int(path.name)]
    named = [
        ("untrained", run.untrained),
        *((f"{int(path.name):,} steps", path) for path in _spread(snapshots)),
        ("trained", run.policy),
    ]
    return [Rung(name, str(path)) for name, path in named if (path / "config.json").is_file()]


def _spread(paths: list[Path]) -> list[Path]:
    """At most so many, as far from each other as they lie."""
    if len(paths) <= SNAPSHOTS:
        return paths
    return [paths[k * (len(paths) - 1) // (SNAPSHOTS - 1)] for k in range(SNAPSHOTS)]


def _of_league(folder: Path, camp: str) -> list[Rung]:
    """The best model of each iteration that was kept; of one that stayed the best, the iteration that made it so."""
    from hexwar_sb3.league.folder import LeagueFolder

    league = LeagueFolder.open(folder)
    done = [k for k in range(league.settings.iterations + 1) if league.is_done(k)]
    best: dict[str, Rung] = {}
    for k in done:
        member = league.kept(k)[camp][0]
        if (member.folder / "config.json").is_file():  # results/ keeps some models alone
            place = str(member.folder)
            best.setdefault(place, Rung(f"iteration {k}: {member.name}", place))
    return list(best.values())
