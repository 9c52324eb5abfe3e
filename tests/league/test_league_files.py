"""What a stranger's league leads to: one of our errors for every broken file, before anything is played."""

from __future__ import annotations

import json
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import FileFormatError, HexWarError
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.league.cost import FILE, read_cost
from hexwar_sb3.league.folder import FORMAT
from hexwar_sb3.league.league import League
from hexwar_sb3.league.settings import LeagueSettings


def head(settings: LeagueSettings) -> dict[str, Any]:
    return {"format": FORMAT, "settings": asdict(settings), **provenance(settings.scenario)}


def test_nothing_but_our_errors_comes_of_a_bad_league(tiny: LeagueSettings, bad: Any, tmp_path: Path) -> None:
    (tmp_path / "league.json").write_text(json.dumps(head(tiny)))
    assert League.open(tmp_path).settings == tiny
    refused = 0
    for content in islice(bad(json.loads(json.dumps(head(tiny)))), 0, None, 2):
        (tmp_path / "league.json").write_bytes(content)
        try:
            League.open(tmp_path)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 200


@pytest.mark.parametrize(
    ("change", "said"),
    [({"keep": 17}, "keep must be at most 16, got 17"), ({"opponents": ["MA7"]}, "unknown opponent 'MA7'")],
)
def test_a_setting_that_cannot_be_is_refused_with_file_and_place(
    tiny: LeagueSettings, change: dict[str, Any], said: str, tmp_path: Path
) -> None:
    spoilt = json.loads(json.dumps(head(tiny)))
    spoilt["settings"].update(change)
    (tmp_path / "league.json").write_text(json.dumps(spoilt))

    with pytest.raises(FileFormatError, match=rf"league\.json: settings: found {said}"):
        League.open(tmp_path)


ROW = {
    "name": "one",
    "score": 0.7,
    "win_rate": 0.5,
    "win_rate_interval": [0.4, 0.6],
    "behind": 0.1,
    "mean_margin": 1.0,
}
TABLE: dict[str, Any] = {
    "iteration": 1,
    "kept": {"red": ["one", "one"], "blue": ["one", "one"]},
    "standings": {"red": [{**ROW, "parent": "zero"}], "blue": [ROW]},
}


@pytest.fixture
def league(tiny: LeagueSettings, tmp_path: Path) -> League:
    """A league with a table of its first iteration, and nothing else."""
    made = League(tmp_path, tiny)
    made.iteration(1).mkdir(parents=True)
    made.table(1).write_text(json.dumps(TABLE))
    return made


def test_a_table_is_read_row_by_row(league: League) -> None:
    rows = league.standings(1)
    assert [(row["name"], row["parent"]) for row in (rows["red"][0], rows["blue"][0])] == [
        ("one", "zero"),
        ("one", None),
    ]


def test_nothing_but_our_errors_comes_of_a_bad_table(league: League, bad: Any) -> None:
    refused = 0
    for content in bad(TABLE):
        league.table(1).write_bytes(content)
        for read in (league.standings, league.kept):
            try:
                read(1)
            except (HexWarError, OSError):
                refused += 1
    assert refused > 400


@pytest.mark.parametrize(
    "change",
    [
        {"win_rate": 1.5},
        {"win_rate": "x"},
        {"win_rate": True},
        {"score": -0.1},
        {"behind": 2.0},
        {"name": 1},
        {"mean_margin": None},
        {"parent": []},
        {"x": 1},
    ],
)
def test_a_row_that_is_none_is_refused(change: dict[str, Any], league: League) -> None:
    table = {**TABLE, "standings": {**TABLE["standings"], "blue": [{**ROW, **change}]}}
    league.table(1).write_text(json.dumps(table))
    with pytest.raises(FileFormatError, match=r"standings\.blue\[0\]"):
        league.standings(1)


def test_costs_of_other_kinds_are_none(bad: Any, tmp_path: Path) -> None:
    """No result depends on them, so a broken file counts as none."""
    good = {"groups": {"wall_s": 1.0, "core_s": 2.0, "peak_mb": 3.0}}
    for content in bad(good):
        (tmp_path / FILE).write_bytes(content)
        found = read_cost(tmp_path)
        assert all(isinstance(value, int | float) for part in found.values() for value in part.values())
    (tmp_path / FILE).write_text(json.dumps(good))
    assert read_cost(tmp_path) == good
