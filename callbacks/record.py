"""Games of the learning policy, written down while it learns."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.engine.picture import save_game_picture
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.play.recording import record_game


class RecordGame(EverySteps):
    """Writes one game of the present policy: `step_000024000.hwr`, and its picture beside it.

    Args:
        every: env steps between two games.
        opponent: name or folder.
        scenario: where the game is played.
        seed: the user's seed.
        folder: gets the files.
        camp: "red" or "blue", of the policy.
    """

    def __init__(
        self, every: int, opponent: str, *, scenario: str, seed: int, folder: Path, camp: str = "red"
    ) -> None:
        super().__init__(every)
        self.opponent, self.scenario, self.camp = opponent, scenario, camp
        self.seed, self.folder = seed, folder

    def fire(self) -> None:
        """Play, record, draw."""
        path = self.folder / f"step_{self.model.num_timesteps:09d}.hwr"
        policy = cast("QMIX", self.model).policy.freeze()
        write_game(path, policy, self.opponent, scenario=self.scenario, seed=self.seed, camp=self.camp)


def write_game(path: Path, player: object, opponent: object, *, scenario: str, seed: int, camp: str) -> None:
    """Record one game of a player and write it as `path`, its picture beside it."""
    red, blue = (player, opponent) if camp == "red" else (opponent, player)
    replay = record_game(red, blue, scenario, seed_for(Purpose.SELECTION, seed))
    replay.save(path)
    save_game_picture(replay, path.with_suffix(".png"))
