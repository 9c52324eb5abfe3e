"""Win rate and margin against fixed opponents while a model learns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.curve import draw_curve
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.panel import CAMPS, play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose


class WinRateCallback(EverySteps):
    """Plays the frozen policy against each opponent in both colours and keeps the best model.

    "Best" is by mean margin: a win rate saturates while one control point of two is held
    (learning.md). The games use seeds of the selection range, and no random numbers of the trainer.

    Args:
        every: env steps between two evaluations.
        opponents: names or folders.
        scenario: where the games are played.
        games: games an opponent and colour.
        seed: the user's seed.
        folder: gets `evaluations.npz`, `learning_curve.png`, `best_model.zip` and `policy/`, the best one.
        about: texts for `policy/config.json`.
        camps: the camps that the model plays.
    """

    def __init__(
        self,
        every: int,
        opponents: Sequence[str],
        *,
        scenario: str,
        games: int,
        seed: int,
        folder: Path,
        about: Mapping[str, str],
        camps: Sequence[str] = CAMPS,
    ) -> None:
        super().__init__(every)
        self.opponents, self.scenario, self.games, self.camps = opponents, scenario, games, camps
        self.seed, self.folder, self.about = seed, folder, about
        self.history = History()

    @property
    def last(self) -> CampResult | None:
        """The latest evaluation; None before the first."""
        return self.history.results[-1] if self.history.results else None

    def _on_training_start(self) -> None:
        super()._on_training_start()
        if self.model.num_timesteps == 0:
            self.fire()  # where it starts from
        else:
            self.history = History.load(self.folder / "evaluations.npz", until=self.model.num_timesteps)

    def fire(self) -> None:
        """Evaluate, record, draw, and save the model if it is the best so far."""
        best = max((result.mean_margin.value for result in self.history.results), default=float("-inf"))
        policy = cast("QMIX", self.model).policy.freeze(**self.about)
        panel = play_panel(
            policy,
            self.opponents,
            name="trained",
            games=self.games,
            scenario=self.scenario,
            seed=self.seed,
            purpose=Purpose.SELECTION,
            camps=self.camps,
        )
        result = self.history.add(self.model.num_timesteps, panel)
        self.logger.record("eval/win_rate", result.win_rate.value)
        self.logger.record("eval/mean_margin", result.mean_margin.value)
        self.logger.record("eval/points_held", float(result.points_held.mean()))
        self.logger.record("time/total_timesteps", self.model.num_timesteps, exclude="tensorboard")
        self.logger.dump(self.model.num_timesteps)
        self.history.save(self.folder / "evaluations.npz")
        draw_curve(self.history, self.folder / "learning_curve.png")
        if result.mean_margin.value > best:
            self.model.save(self.folder / "best_model.zip")
            policy.save(self.folder / "policy")
