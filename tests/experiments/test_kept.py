"""Pages and curves that the experiments read back, also broken ones."""

from __future__ import annotations

import json
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import FileFormatError, HexWarError
from hexwar_sb3.experiments.curve import HEADS, read_curve
from hexwar_sb3.experiments.kept import CURVES, RUNS, Kept

ROW = {
    "player": "trained",
    "opponent": "MA1",
    "camp": "red",
    "win_rate": 0.5,
    "mean_margin": -3.0,
    "points_held": [0.5, 0.5],
}
PAGE = {"minutes": 3.5, "rows": [ROW], "seed": 0}
RECORD = {"command": "hexwar train", "config": {}, "page": PAGE}


def test_a_page_comes_back(tmp_path: Path) -> None:
    (tmp_path / RUNS).write_text(json.dumps({"one": RECORD}))
    kept = Kept(tmp_path, "one")
    assert kept.is_there
    assert kept.minutes == 3.5
    assert kept.rows()[0].points_held == (0.5, 0.5)


def test_a_run_that_is_not_there_is_named(tmp_path: Path) -> None:
    (tmp_path / RUNS).write_text(json.dumps({"one": RECORD}))
    other = Kept(tmp_path, "two")
    assert not other.is_there
    with pytest.raises(FileFormatError, match=r"runs\.json.*two"):
        other.rows()


def test_a_file_that_changed_is_read_again(tmp_path: Path) -> None:
    for minutes in (1.0, 2.0):
        page = {**PAGE, "minutes": minutes}
        (tmp_path / RUNS).write_text(json.dumps({"one": {**RECORD, "page": page}}))
        assert Kept(tmp_path, "one").minutes == minutes


def test_nothing_but_our_errors_comes_of_a_bad_page(bad: Any, tmp_path: Path) -> None:
    refused = 0
    for content in bad({"one": RECORD}):
        (tmp_path / RUNS).write_bytes(content)
        for read in (attrgetter("minutes"), Kept.rows):
            try:
                read(Kept(tmp_path, "one"))
            except (HexWarError, OSError):
                refused += 1
    assert refused > 150


GOOD = ",".join(("run", *HEADS)) + "\none,600,1,2,MA1" + ",0.5" * 7 + "\n"
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
    path = tmp_path / CURVES
    path.write_bytes(BAD[what])
    with pytest.raises(FileFormatError, match=r"curves\.csv"):
        read_curve(path, "one", "MA1")


def test_a_whole_curve_is_read(tmp_path: Path) -> None:
    (tmp_path / CURVES).write_text(GOOD)
    assert read_curve(tmp_path / CURVES, "one", "MA1")["win_rate"] == [0.5]
