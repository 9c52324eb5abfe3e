"""The page of a league: who beat whom in each iteration, recorded games, and who comes from whom."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.commands.albums import album_of
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.league.league import League


@pytest.mark.slow
@pytest.mark.parametrize("which", ["whole", "split"])
def test_a_league_has_its_tables_its_games_and_its_lineage(
    which: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    made: League = request.getfixturevalue(which)
    shutil.copytree(made.folder, tmp_path / "league")
    league = League.open(tmp_path / "league")
    league.record_games(2, command="hexwar selfplay")
    album = album_of([league.folder])

    games = {path.name for path in (league.iteration(2) / "games").glob("*.hwr")}
    assert {clip.path.name for clip in album.clips} == games
    kept = {camp: {one.name for one in league.kept(2)[camp]} for camp in ("red", "blue")}
    bots = len(league.settings.weights)
    assert len(games) == len(kept["red"]) * len(kept["blue"]) + bots * (len(kept["red"]) + len(kept["blue"]))
    assert Replay.load(album.clips[0].path).head["command"] == "hexwar selfplay"

    cover: Any = album.cover
    last, first = cover["tables"]
    assert (last["name"], first["name"]) == ("iteration 2", "iteration 1")
    rates = league.red_win_rates(2)
    for red, row in zip(last["red"], last["cells"], strict=True):
        for blue, cell in zip(last["blue"], row, strict=True):
            assert (cell is None) == (f"{red} {blue}" not in rates)
            if cell is not None:
                assert cell["rate"][0] == pytest.approx(rates[f"{red} {blue}"], abs=1e-4)
                recorded = {red, blue} <= kept["red"] | kept["blue"] | set(league.settings.weights)
                if "game" in cell:
                    assert recorded
                    assert album.clips[cell["game"] - 1].name == f"{red} against {blue}"
    lines = cover["lineage"]
    assert set(lines) == ({"red", "blue"} if which == "split" else {"both"})
    for generations in lines.values():
        assert len(generations) == 3
        assert all(one["parent"] is None for one in generations[0])
        assert all(one["parent"] for one in generations[2])

    album.save(tmp_path / "league.html")
    assert (tmp_path / "league.html").stat().st_size < 2_000_000


def test_a_league_that_was_kept_without_its_matches_shows_its_rates(whole: League, tmp_path: Path) -> None:
    """As the results of Table I are: tables, and the models that it began with."""
    whole.keep(tmp_path / "kept", models=False)
    album = album_of([tmp_path / "kept"])

    cover: Any = album.cover
    assert not album.clips
    assert [table["name"] for table in cover["tables"]] == ["iteration 2", "iteration 1"]
    assert any(cell for row in cover["tables"][0]["cells"] for cell in row)
    album.save(tmp_path / "league.html")
