"""Pages of what trainings and tournaments leave, and of folders that are none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.cli import main
from hexwar_sb3.commands.albums import album_of, save_at_end
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.evaluation.history import History
from hexwar_sb3.evaluation.intervals import wilson
from hexwar_sb3.evaluation.played import read_matches, table_of_rates
from hexwar_sb3.evaluation.results import CampResult


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    return int(str(stopped.value.code))


@pytest.fixture
def game(tmp_path: Path) -> Path:
    """A game that has hardly begun."""
    Replay.of(Game("plain", seed=0)).save(tmp_path / "game.hwr")
    return tmp_path / "game.hwr"


@pytest.fixture
def trained(tmp_path: Path, game: Path) -> Path:
    """A run folder with three evaluations and two games of its snapshots."""
    folder = tmp_path / "run_1"
    for name in ("red_000000200_against_MA1", "red_000000000_against_MA1", "red_against_MA1"):
        (folder / "replays").mkdir(parents=True, exist_ok=True)
        (folder / "replays" / f"{name}.hwr").write_bytes(game.read_bytes())
    result = CampResult(np.array([1.0, 0.0]), np.array([10.0, -4.0]), np.array([1, 0]))
    History([0, 100, 200], [0, 9, 18], [result] * 3).save(folder / "evaluations.npz")
    return folder


def camp(player: str, wins: int, losses: int) -> dict[str, Any]:
    rate = wilson(wins, wins + losses)
    return {
        "player": player,
        "games": wins + losses,
        "wins": wins,
        "draws": 0,
        "losses": losses,
        "win_rate": rate.value,
        "win_rate_interval": [rate.low, rate.high],
        "mean_margin": 0.0,
        "mean_margin_interval": [-1.0, 1.0],
        "points_held": [1.0],
    }


@pytest.fixture
def played(tmp_path: Path, game: Path) -> Path:
    """A tournament's folder: two players, one of whose matches has its game."""
    folder = tmp_path / "cup"
    for name in ("matches", "games"):
        (folder / name).mkdir(parents=True)
    for red, blue, wins in (("MA1", "MA2", 3), ("MA2", "MA1", 1)):
        row = {
            "red": camp(red, wins, 4 - wins),
            "blue": camp(blue, 4 - wins, wins),
            "seed": 9,
            "median_game": 2,
        }
        (folder / "matches" / f"plain~{red}~{blue}.json").write_text(json.dumps(row))
    (folder / "games" / "plain~MA1~MA2.hwr").write_bytes(game.read_bytes())
    return folder


def test_an_album_begins_untrained_and_its_curve_leads_to_its_games(trained: Path) -> None:
    album = album_of([trained])

    assert [clip.name for clip in album.clips] == ["untrained", "200 steps"]
    curve: Any = album.cover["curve"]
    assert [(row[0], row[1]) for row in curve["rows"]] == [(0, 1), (100, 0), (200, 2)]
    assert curve["rows"][0][2][0] == 0.5
    assert curve["games"] == 2


def test_a_run_that_started_from_a_model_is_not_untrained(trained: Path) -> None:
    (trained / "config.json").write_text('{"trained_agent": "other/model.zip"}')

    assert album_of([trained]).clips[0].name == "as it began"


def test_a_cell_of_a_tournament_leads_to_its_median_game(played: Path) -> None:
    album = album_of([played])

    tables: Any = album.cover["tables"]
    (table,) = tables
    assert (table["name"], table["red"], table["blue"]) == ("plain", ["MA1", "MA2"], ["MA1", "MA2"])
    cell = table["cells"][0][1]
    assert (cell["game"], cell["episode"], cell["seed"], cell["games"]) == (1, 2, 9, 4)
    assert cell["rate"][0] == 0.75
    assert table["cells"][0][0] is None
    assert "game" not in table["cells"][1][0]  # was not recorded


def test_a_table_of_rates_has_its_intervals() -> None:
    table = table_of_rates({"a b": 0.75, "b a": 0.5}, "plain", 60)

    assert table.win_rate("a", "red", "blue").value == pytest.approx((45 + 30) / 120)
    (row, _) = table.rows.values()
    assert row["red"]["win_rate_interval"][0] == pytest.approx(wilson(45, 60).low)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("plain~MA1.json", "{}", "name: found plain~MA1; expected SCENARIO~RED~BLUE"),
        ("plain~MA1~MA2.json", "{", "a match"),
        ("plain~MA1~MA2.json", '{"red": {}}', "red.player: found nothing"),
        ("plain~MA1~MA2.json", json.dumps({"red": camp("a", 1, 1) | {"games": 3}}), "red.games: found 3"),
        ("plain~MA1~MA2.json", json.dumps({"red": camp("a", 1, 1) | {"win_rate": 0.9}}), "red.win_rate"),
    ],
)
def test_a_broken_match_is_refused_with_its_place(name: str, text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)

    with pytest.raises(FileFormatError) as error:
        read_matches(tmp_path)
    assert name in str(error.value)
    assert message in str(error.value) or message == "a match"


def test_a_folder_without_games_is_refused(tmp_path: Path, trained: Path) -> None:
    (tmp_path / "empty").mkdir()

    with pytest.raises(ConfigError, match="no recorded games"):
        album_of([tmp_path / "empty"])
    with pytest.raises(ConfigError, match="name one folder"):
        album_of([trained, tmp_path / "empty"])


def test_two_files_are_put_side_by_side_and_three_are_listed(game: Path) -> None:
    assert album_of([game, game]).cover["kind"] == "compare"
    assert album_of([game, game, game]).cover["kind"] == "games"


def test_what_is_wrong_at_the_end_of_a_command_is_said(
    trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (trained / "evaluations.npz").write_bytes(b"nothing")

    save_at_end(lambda: album_of([trained]), tmp_path / "album.html")

    assert "no page: " in capsys.readouterr().err
    assert not (tmp_path / "album.html").exists()


def test_the_command_writes_pages_of_folders_and_files(
    trained: Path, game: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"

    assert run("watch", str(trained), "-o", str(page)) == 0
    capsys.readouterr()
    assert 'id="game-2"' in page.read_text()
    assert run("watch", str(game), str(game), "-o", str(page), "--view", "blue", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["games"]) == 2
    assert run("watch", str(game), str(game), "-o", str(tmp_path / "film.gif")) == 2
    assert "several games make a page" in capsys.readouterr().err
    assert run("watch") == 2
