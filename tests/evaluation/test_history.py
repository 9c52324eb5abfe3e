from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.panel import Panel
from hexwar_sb3.evaluation.results import CampResult


def panel(margin: float) -> Panel:
    result = CampResult(np.array([1.0, 0.5]), np.array([margin, 0.0]), np.array([2, 1]))
    return Panel("trained", {("MA1", "red"): result, ("MA1", "blue"): result})


@pytest.fixture
def history() -> History:
    history = History()
    history.add(100, 9_000, panel(10.0))
    history.add(200, 18_000, panel(20.0))
    return history


def test_a_saved_history_comes_back(history: History, tmp_path: Path) -> None:
    history.save(tmp_path / "evaluations.npz")

    loaded = History.load(tmp_path / "evaluations.npz")

    assert (loaded.timesteps, loaded.game_ticks) == ([100, 200], [9_000, 18_000])
    assert [result.mean_margin.value for result in loaded.results] == [5.0, 10.0]


def test_a_resumed_run_forgets_what_came_after_its_checkpoint(history: History, tmp_path: Path) -> None:
    history.save(tmp_path / "evaluations.npz")

    loaded = History.load(tmp_path / "evaluations.npz", until=150)

    assert (loaded.timesteps, loaded.game_ticks) == ([100], [9_000])


def test_the_file_has_the_keys_of_stable_baselines3(history: History, tmp_path: Path) -> None:
    history.save(tmp_path / "evaluations.npz")

    with np.load(tmp_path / "evaluations.npz") as data:
        assert data["timesteps"].shape == (2,)
        assert data["results"].shape == data["successes"].shape == (2, 4)


def test_a_broken_file_says_where_and_what(tmp_path: Path) -> None:
    (tmp_path / "evaluations.npz").write_bytes(b"PK\x03\x04 no more")

    with pytest.raises(FileFormatError, match=r"evaluations\.npz: file: found .*; expected arrays"):
        History.load(tmp_path / "evaluations.npz")


GOOD: dict[str, Any] = {
    "timesteps": np.array([100, 200]),
    "game_ticks": np.array([9_000, 18_000]),
    "results": np.zeros((2, 4)),
    "successes": np.ones((2, 4)),
    "points_held": np.ones((2, 4), np.int64),
}
SWAPS: dict[str, Any] = {
    "objects": np.array([[None] * 4] * 2, dtype=object),
    "texts": np.array([["x"] * 4] * 2),
    "complex numbers": np.ones((2, 4), complex),
    "no numbers": np.full((2, 4), np.nan),
    "huge numbers": np.full((2, 4), 1e300),
    "one axis more": np.ones((2, 4, 1)),
    "none": np.ones(()),
    "fewer rows": np.ones((1, 4)),
    "below nothing": np.full((2, 4), -1e17),
}


@pytest.mark.parametrize("key", GOOD)
@pytest.mark.parametrize("swap", SWAPS)
def test_an_array_of_another_kind_is_named(swap: str, key: str, tmp_path: Path) -> None:
    path = tmp_path / "evaluations.npz"
    np.savez(path, **{**GOOD, key: SWAPS[swap]})
    with pytest.raises(FileFormatError, match=r"evaluations\.npz"):
        History.load(path)
    np.savez(path, **{name: array for name, array in GOOD.items() if name != key})
    with pytest.raises(FileFormatError, match="found arrays"):
        History.load(path)
    np.savez(path, **GOOD)
    assert History.load(path).timesteps == [100, 200]


@pytest.mark.parametrize("key", ["timesteps", "game_ticks"])
def test_evaluations_follow_one_another(key: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "evaluations.npz", **{**GOOD, key: GOOD[key][::-1]})

    with pytest.raises(FileFormatError, match=f"{key}: found numbers that fall"):
        History.load(tmp_path / "evaluations.npz")


@pytest.mark.parametrize("how", ["array", "flipped", "missing", "folder"])
def test_a_file_that_is_none_is_refused(how: str, history: History, tmp_path: Path) -> None:
    path = tmp_path / "evaluations.npz"
    history.save(path)
    data = bytearray(path.read_bytes())
    path.unlink()
    if how == "array":
        with path.open("wb") as file:
            np.save(file, np.zeros(3))
    elif how == "flipped":
        data[len(data) // 4] ^= 255
        path.write_bytes(data)
    elif how == "folder":
        path.mkdir()

    with pytest.raises(FileFormatError, match=r"evaluations\.npz: .*found "):
        History.load(path)


def test_a_run_without_evaluations_has_none(tmp_path: Path) -> None:
    History().save(tmp_path / "evaluations.npz")

    assert History.load(tmp_path / "evaluations.npz") == History()
