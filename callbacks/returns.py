"""Returns of greedy episodes while a model learns in a game of others: a table, a picture, the best model."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.evaluation.csv_file import number_in, read_rows
from hexwar_sb3.files import replacing
from hexwar_sb3.pictures import colour, draw_band, dress, new_figure, write_figure

COLUMNS = ("env_steps", "episodes", "mean_return", "standard_error", "mean_length")
TABLE, PICTURE, BEST = "evaluations.csv", "learning_curve.png", "best_model.zip"


class ReturnsCallback(EverySteps):
    """Plays greedy episodes on the same seeds each time, and keeps the model of the highest mean return.

    Args:
        every: env steps between two evaluations.
        env: for the evaluations alone; its games are seeded when an evaluation begins.
        folder: gets `evaluations.csv`, `learning_curve.png` and `best_model.zip`.
        episodes: of an evaluation.
        seed: of the first game; the next one has the next seed.
        title: of the picture.
    """

    def __init__(
        self, every: int, env: VecEnv, folder: Path, *, episodes: int = 100, seed: int = 0, title: str = ""
    ) -> None:
        super().__init__(every)
        self.eval_env, self.folder, self.episodes, self.seed, self.title = env, folder, episodes, seed, title
        self.rows: list[dict[str, float]] = []

    def _on_training_start(self) -> None:
        super()._on_training_start()
        if self.now() == 0:
            self.fire()  # where it starts from
        else:
            self.rows = [row for row in read_returns(self.folder / TABLE) if row["env_steps"] <= self.now()]

    def fire(self) -> None:
        """Evaluate, record, draw, and save the model if it is the best so far."""
        self.eval_env.seed(self.seed)
        found = evaluate_policy(
            self.model, self.eval_env, self.episodes, deterministic=True, return_episode_rewards=True
        )
        returns, lengths = np.asarray(found[0], np.float64), np.asarray(found[1], np.float64)
        best = max((row["mean_return"] for row in self.rows), default=-math.inf)
        error = returns.std(ddof=1) / math.sqrt(len(returns)) if len(returns) > 1 else math.nan
        numbers = (self.now(), len(returns), returns.mean(), error, lengths.mean())
        row = dict(zip(COLUMNS, map(float, numbers), strict=True))
        self.rows.append(row)
        self.logger.record("eval/mean_return", row["mean_return"])
        self.logger.record("time/total_timesteps", self.now(), exclude="tensorboard")
        self.logger.dump(self.now())
        write_returns(self.rows, self.folder / TABLE)
        draw_returns(self.rows, self.folder / PICTURE, self.title)
        if row["mean_return"] > best:
            with replacing(self.folder / BEST) as temporary:
                self.model.save(temporary)


def write_returns(rows: list[dict[str, float]], path: Path) -> None:
    """Write the table of all evaluations."""
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    table.writerows(
        {name: "" if math.isnan(row[name]) else f"{row[name]:.6g}" for name in COLUMNS} for row in rows
    )
    with replacing(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8")


def read_returns(path: Path) -> list[dict[str, float]]:
    """Read what `write_returns` wrote.

    Raises:
        FileFormatError: it is missing or broken.
    """
    return [{name: number_in(row, name, path) for name in COLUMNS} for row in read_rows(path)]


def draw_returns(rows: list[dict[str, float]], path: Path, title: str = "") -> None:
    """Draw mean returns over env steps, with bands of 95 %."""
    figure = new_figure(7, 4)
    axes = figure.subplots()
    steps, mean, error = (
        np.array([row[name] for row in rows]) for name in ("env_steps", "mean_return", "standard_error")
    )
    wide = 1.96 * np.nan_to_num(error)
    draw_band(axes, steps, mean, mean - wide, mean + wide, color=colour(0))
    dress(
        axes,
        f"{title}; band: 95 % interval".removeprefix("; "),
        xlabel="env steps",
        ylabel=f"mean return of {int(rows[-1]['episodes'])} greedy episodes",
    )
    write_figure(figure, path)
