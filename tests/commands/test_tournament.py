"""`hexwar tournament`: names, files, and a second call that plays nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hexwar_sb3.cli import main
from hexwar_sb3.commands.tournament import named
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(["tournament", *arguments])
    return int(str(stopped.value.code))


def test_a_tournament_leaves_table_picture_and_matches(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("MA1", "nearest", "any=random", "--games", "3", "--output", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["hexwar", "tournament", *words])
    assert run(*words) == 0
    printed = capsys.readouterr().out
    made = {path: path.stat().st_mtime_ns for path in (tmp_path / "matches").glob("*.json")}
    assert run(*words, "--json") == 0
    figures = json.loads(capsys.readouterr().out)

    games = sorted((tmp_path / "games").glob("*.hwr"))
    assert [path.stem for path in games] == sorted(path.stem for path in made)
    replay = Replay.load(tmp_path / "games" / "plain~MA1~nearest.hwr")
    row = json.loads((tmp_path / "matches" / "plain~MA1~nearest.json").read_text())
    margins = Evaluation(games=3, seed=0).play("MA1", "nearest").red.margins
    assert replay.end["margin"]["red"] == sorted(margins)[1] == margins[row["median_game"]]
    assert replay.head["command"].startswith("hexwar tournament MA1 nearest")
    other = Replay.load(tmp_path / "games" / "plain~any~MA1.hwr")
    assert other.head["players"]["red"]["name"] == "any"  # as the table calls it
    assert len(made) == 6
    assert all(path.stat().st_mtime_ns == time for path, time in made.items())
    assert printed.startswith((tmp_path / "table.txt").read_text().rstrip())
    assert (tmp_path / "tournament.png").stat().st_size > 10_000
    assert set(figures["elo"]["players"]) == {"MA1", "nearest", "any"}
    assert figures["elo"]["players"]["MA1"][0] > figures["elo"]["players"]["any"][0]


def test_each_map_has_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        run("nearest", "random", "--games", "2", "--scenarios", "plain", "hills", "--output", str(tmp_path))
        == 0
    )
    printed = capsys.readouterr().out

    assert '"plain": win rate of red (rows)' in printed
    assert '"hills": win rate of red (rows)' in printed


def test_players_are_called_by_what_tells_them_apart() -> None:
    assert named(("MA1", "runs/a_1/policy", "runs/b_1/policy", "best=runs/c_1")) == {
        "MA1": "MA1",
        "a_1-policy": "runs/a_1/policy",
        "b_1-policy": "runs/b_1/policy",
        "best": "runs/c_1",
    }
    assert list(named(("../x/y", "x/z/"))) == ["y", "z"]


WRONG = {
    "twice": (("MA1", "MA1"), "two players are called MA1"),
    "a path as a name": (("../x=MA1",), "name of a player must be of letters"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_name_is_given_once_and_names_a_file(what: str) -> None:
    words, message = WRONG[what]
    with pytest.raises(ConfigError, match=message):
        named(words)


MISTAKES = {
    "alone": (("MA1",), "needs two players"),
    "unknown": (("MA1", "MA7"), "unknown player 'MA7'"),
    "no games": (("MA1", "MA2", "--games", "0"), "games must be at least 1"),
    "no jobs": (("MA1", "MA2", "--jobs", "0"), "jobs must be at least 1, got 0"),
    "two maps of a name": (
        ("MA1", "MA2", "--scenarios", "a/x.json", "b/x.json"),
        "two scenarios have one name",
    ),
    "no such map": (("MA1", "MA2", "--scenarios", "planes"), "unknown scenario 'planes'"),
}


@pytest.mark.parametrize("what", MISTAKES)
def test_a_mistake_is_one_line(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words, message = MISTAKES[what]
    assert run(*words, "--output", str(tmp_path / "t")) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not (tmp_path / "t").exists()
