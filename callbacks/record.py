"""Games of the learning policy, written down while it learns."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.engine.picture import save_game_picture
from hexwar_sb3.evaluation.matches import Evaluation

ALBUM_GAMES = 12  # of a training, at most: half a second each to write down


class RecordGame(EverySteps):
    """Writes a game of the present policy for each camp: `red_000024000.hwr`, and its picture beside it.

    Args:
        every: env steps between two games.
        opponent: name or folder.
        evaluation: how they are played.
        folder: gets the files.
    """

    def __init__(self, every: int, opponent: str, evaluation: Evaluation, *, folder: Path) -> None:
        super().__init__(every)
        self.opponent, self.evaluation, self.folder = opponent, evaluation, folder

    def fire(self) -> None:
        """Play, record, draw."""
        policy = cast("QMIX", self.model).policy.freeze()
        write_games(policy, self.opponent, self.evaluation, self.folder, f"{self.model.num_timesteps:09d}")


def write_album(snapshots: Path, opponent: str, evaluation: Evaluation, folder: Path) -> list[Path]:
    """Record how a training's policy changed: a few of its snapshots play the same game against one opponent.

    Args:
        snapshots: folder of policies by env steps, as `WinRateCallback` leaves them.
        opponent: name or folder.
        evaluation: how they play; they have the first of its camps.
        folder: gets `CAMP_STEPS_against_OPPONENT.hwr`.

    Returns:
        The replays, the first snapshot's first; none of a training that left no snapshots.
    """
    found = sorted(path for path in snapshots.glob("*") if path.is_dir())
    if not found:
        return []
    camp = evaluation.camps[0]
    chosen = {found[round(k * (len(found) - 1) / (ALBUM_GAMES - 1))]: None for k in range(ALBUM_GAMES)}
    paths = []
    for policy in chosen:
        red, blue = (policy, opponent) if camp == "red" else (opponent, policy)
        paths.append(folder / f"{camp}_{policy.name}_against_{Path(opponent).name}.hwr")
        evaluation.record(red, blue).save(paths[-1])
    return paths


def write_games(player: object, opponent: str, evaluation: Evaluation, folder: Path, name: str) -> None:
    """Record one game of a player for each of its camps: `CAMP_NAME.hwr`, and its picture beside it."""
    for camp in evaluation.camps:
        replay = evaluation.record(player, opponent) if camp == "red" else evaluation.record(opponent, player)
        path = folder / f"{camp}_{name}.hwr"
        replay.save(path)
        save_game_picture(replay, path.with_suffix(".png"))
