"""Win rate and margin against fixed opponents while a model learns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.curve import draw_curve
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.matches import Evaluation, player_name
from hexwar_sb3.evaluation.panel import play_panel


class WinRateCallback(EverySteps):
    """Plays the frozen policy against each opponent in both colours and keeps the best model.

    "Best" is by mean margin: a win rate saturates while one control point of two is held
    (learning.md, section 7). The games use no random numbers of the trainer.

    Args:
        every: env steps between two evaluations.
        opponents: names or folders.
        evaluation: how they are played; their purpose is selection.
        folder: gets `evaluations.npz`, `learning_curve.png`, `best_model.zip` and `policy/`, the best one.
        about: texts for `policy/config.json`.
        threads: opponents side by side.
        snapshots: folder that gets what played in each evaluation, by env steps.
    """

    def __init__(
        self,
        every: int,
        opponents: Sequence[str],
        evaluation: Evaluation,
        *,
        folder: Path,
        about: Mapping[str, str] | None = None,
        threads: int = 1,
        snapshots: Path | None = None,
    ) -> None:
        super().__init__(every)
        self.threads, self.snapshots = threads, snapshots
        self.opponents, self.evaluation, self.folder, self.about = (
            opponents,
            evaluation,
            folder,
            dict(about or {}),
        )
        self.history = History()

    def _on_training_start(self) -> None:
        super()._on_training_start()
        if self.now() == 0:
            self.fire()  # where it starts from
        else:
            self.history = History.load(self.folder / "evaluations.npz", until=self.now())

    def ticks(self) -> int:
        """Game ticks of all levels so far; 0 for a model that does not count them."""
        return int(getattr(self.model, "game_ticks", 0))

    def player(self) -> Any:
        """What plays for the model as it is now."""
        return cast("QMIX", self.model).policy.freeze(**self.about)

    def keep_best(self, player: Any) -> None:
        """Save the model, and what played for it."""
        self.model.save(self.folder / "best_model.zip")
        player.save(self.folder / "policy")

    def fire(self) -> None:
        """Evaluate, record, draw, and save the model if it is the best so far."""
        best = max((result.mean_margin.value for result in self.history.results), default=float("-inf"))
        player, now = self.player(), self.now()
        panel = play_panel(player, self.opponents, self.evaluation, name="trained", threads=self.threads)
        if self.snapshots is not None:
            player.save(self.snapshots / f"{now:09d}")
        result = self.history.add(now, self.ticks(), panel)
        self.logger.record("eval/win_rate", result.win_rate.value)
        self.logger.record("eval/mean_margin", result.mean_margin.value)
        self.logger.record("eval/points_held", float(result.points_held.mean()))
        self.logger.record("time/total_timesteps", now, exclude="tensorboard")
        self.logger.dump(now)
        self.history.save(self.folder / "evaluations.npz")
        terms = self.evaluation.terms
        draw_curve(
            self.history,
            self.folder / "learning_curve.png",
            title=f'On "{load_world(terms.scenario).scenario.name}", as {" and ".join(self.evaluation.camps)}, against {", ".join(map(player_name, self.opponents))}',
            decision_ticks=terms.decision_ticks if terms.decisions == "fixed" else None,
        )
        if result.mean_margin.value > best:
            self.keep_best(player)
