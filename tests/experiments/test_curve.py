from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.experiments.curve import HEADS, curve_rows, read_curve, write_curve

RESULT = CampResult(
    scores=np.array([1.0, 0.5, 0.0, 0.0]),
    margins=np.array([100.0, 0.0, -50.0, -70.0]),
    points_held=np.array([2, 1, 0, 0]),
)


def test_a_curve_has_a_row_for_all_games_and_for_each_opponent() -> None:
    """Games lie opponent by opponent (`play_panel`): the first half is MA1's."""
    history = History([2400], [250_000], [RESULT])

    rows = list(curve_rows(history, ["MA1", "MA2"], decision_ticks=75, game_ticks=1800))

    assert [row["opponent"] for row in rows] == ["all", "MA1", "MA2"]
    assert [row["win_rate"] for row in rows] == [0.375, 0.75, 0.0]
    assert [row["mean_margin"] for row in rows] == [-5.0, 50.0, -60.0]
    assert [row["points_held"] for row in rows] == [0.75, 1.5, 0.0]
    assert {(row["env_steps"], row["games"], row["game_ticks"]) for row in rows} == {(2400, 100, 250_000)}
    assert rows[0]["win_rate_low"] == wilson(1.5, 4).low


def test_games_are_counted_by_time_whatever_delta_t_is() -> None:
    rows = curve_rows(History([600], [180_000], [RESULT]), ["MA1"], decision_ticks=300, game_ticks=1800)

    assert next(rows)["games"] == 100


def test_games_stay_empty_where_decisions_take_no_fixed_time(tmp_path: Path) -> None:
    path = tmp_path / "curves.csv"

    write_curve(
        path,
        "one",
        curve_rows(History([600], [180_000], [RESULT]), ["MA1"], decision_ticks=None, game_ticks=1800),
    )

    assert path.read_text(encoding="utf-8").splitlines()[1].startswith("one,600,,180000,all,0.375,")
    assert np.isnan(read_curve(path, "one", "MA1")["games"]).all()


def test_a_curve_comes_back_from_its_file(tmp_path: Path) -> None:
    path = tmp_path / "curves.csv"
    history = History([0, 2400], [0, 180_000], [RESULT, RESULT])

    write_curve(path, "one", curve_rows(history, ["MA1", "MA2"], decision_ticks=75, game_ticks=1800))

    assert path.read_text(encoding="utf-8").splitlines()[0] == "run," + ",".join(HEADS)
    assert read_curve(path, "one", "MA2")["mean_margin"] == [-60.0, -60.0]
    assert read_curve(path, "one", "MA1")["games"] == [0.0, 100.0]
    assert read_curve(path, "one", "MA1")["win_rate_low"] == pytest.approx([wilson(1.5, 2).low] * 2, rel=1e-5)
