"""Games of the learning policy, written down while it learns."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.engine.picture import save_game_picture
from hexwar_sb3.evaluation.panel import Terms


class RecordGame(EverySteps):
    """Writes a game of the present policy for each camp: `red_000024000.hwr`, and its picture beside it.

    Args:
        every: env steps between two games.
        opponent: name or folder.
        terms: of the games.
        folder: gets the files.
    """

    def __init__(self, every: int, opponent: str, terms: Terms, *, folder: Path) -> None:
        super().__init__(every)
        self.opponent, self.terms, self.folder = opponent, terms, folder

    def fire(self) -> None:
        """Play, record, draw."""
        policy = cast("QMIX", self.model).policy.freeze()
        write_games(policy, self.opponent, self.terms, self.folder, f"{self.model.num_timesteps:09d}")


def write_games(player: object, opponent: str, terms: Terms, folder: Path, name: str) -> None:
    """Record one game of a player for each of its camps: `CAMP_NAME.hwr`, and its picture beside it."""
    for camp in terms.camps:
        replay = terms.record(player, opponent) if camp == "red" else terms.record(opponent, player)
        path = folder / f"{camp}_{name}.hwr"
        replay.save(path)
        save_game_picture(replay, path.with_suffix(".png"))
