"""The picture of a training."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hexwar_sb3.callbacks.curve import draw_curve, lower_phases
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.results import CampResult


def history() -> History:
    """Four evaluations; between the second and the third the lower level learned for 2,000 ticks, too."""
    made = History(timesteps=[0, 100, 200, 300], game_ticks=[0, 7_500, 17_000, 24_500])
    made.results = [CampResult(np.full(4, 0.5), np.arange(4.0), np.ones(4, int)) for _ in made.timesteps]
    return made


def test_phases_of_the_lower_level_are_those_that_took_more_game_time() -> None:
    assert list(lower_phases(history(), 75)) == [(100, 200)]


def test_a_learning_curve_is_drawn_whole(tmp_path: Path) -> None:
    draw_curve(history(), tmp_path / "curve.png", title="On plain", decision_ticks=75)

    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")
