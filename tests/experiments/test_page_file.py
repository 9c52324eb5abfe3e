"""Pages and curves that the experiments read back, also broken ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import FileFormatError, HexWarError
from hexwar_sb3.experiments.curve import HEADS, read_curve
from hexwar_sb3.experiments.page_file import FILE, minutes_on, rows_on

ROW = {
    "player": "trained",
    "opponent": "MA1",
    "camp": "red",
    "win_rate": 0.5,
    "mean_margin": -3.0,
    "points_held": [0.5, 0.5],
}
PAGE = {"minutes": 3.5, "rows": [ROW], "seed": 0}


def test_a_page_comes_back(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(json.dumps(PAGE))
    assert minutes_on(tmp_path) == 3.5
    assert rows_on(tmp_path)[0].points_held == (0.5, 0.5)


def test_nothing_but_our_errors_comes_of_a_bad_page(bad: Any, tmp_path: Path) -> None:
    refused = 0
    for content in bad(PAGE):
        (tmp_path / FILE).write_bytes(content)
        for read in (minutes_on, rows_on):
            try:
                read(tmp_path)
            except (HexWarError, OSError):
                refused += 1
    assert refused > 150


GOOD = ",".join(HEADS) + "\n600,1,2,MA1" + ",0.5" * 7 + "\n"
BAD: dict[str, bytes] = {
    "another opponent": GOOD.replace("MA1", "MA2").encode(),
    "a text for a number": GOOD.replace("0.5", "half", 1).encode(),
    "NaN": GOOD.replace("0.5", "nan", 1).encode(),
    "infinity": GOOD.replace("0.5", "inf", 1).encode(),
    "a column less": GOOD.replace("points_held", "x").encode(),
    "a field less": GOOD.replace(",0.5", "", 1).encode(),
    "no text": b"\xff\xfe",
    "a NUL": GOOD.replace("0.5", "0\0", 1).encode(),
    "a huge field": GOOD.replace("0.5", "5" * 200_000, 1).encode(),
    "nothing": b"",
    "5 MB": GOOD.encode() + b"\n" * 5_000_000,
}


@pytest.mark.parametrize("what", BAD)
def test_a_broken_curve_is_named(what: str, tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    path.write_bytes(BAD[what])
    with pytest.raises(FileFormatError, match=r"curve\.csv"):
        read_curve(path, "MA1")


def test_a_whole_curve_is_read(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text(GOOD)
    assert read_curve(tmp_path / "curve.csv", "MA1")["win_rate"] == [0.5]
