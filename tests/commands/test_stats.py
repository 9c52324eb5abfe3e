"""`hexwar stats`: of a player and of replays, in words and pictures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hexwar_sb3.cli import main
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(["stats", *arguments])
    return int(str(stopped.value.code))


def test_statistics_of_a_player(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = run("HRL0", "--opponents", "MA1", "--games", "1", "--output", str(tmp_path / "out"))
    printed = capsys.readouterr().out

    assert code == 0
    assert printed.startswith("How HRL0 plays: 2 games")
    assert "deployment" in printed
    assert (tmp_path / "out" / "stats.txt").read_text() == printed
    figures = json.loads((tmp_path / "out" / "stats.json").read_text())
    assert (figures["player"], figures["games"], len(figures["claims"])) == ("HRL0", 2, 6)
    made = sorted(
        path.name for path in (tmp_path / "out").iterdir() if path.suffix in (".png", ".svg", ".pdf")
    )
    assert made == [
        f"{name}{end}" for name in ("places", "targets", "tasks") for end in (".pdf", ".png", ".svg")
    ]


def test_statistics_of_replays_are_those_of_who_is_in_all_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record_game("HRL0", "MA1", seed=1).save(tmp_path / "a.hwr")
    record_game("nearest", "HRL0", seed=1).save(tmp_path / "b.hwr")

    assert run(str(tmp_path), "--json") == 0
    figures = json.loads(capsys.readouterr().out)

    assert (figures["player"], figures["games"]) == ("HRL0", 2)


def test_the_folder_of_a_run_is_a_player_though_replays_lie_in_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy = make_player("HRL0")
    assert isinstance(policy, FrozenPolicy)
    policy.save(tmp_path / "run" / "policy")
    record_game("MA2", "MA1", seed=1).save(tmp_path / "run" / "replays" / "a.hwr")

    assert run(str(tmp_path / "run"), "--opponents", "MA1", "--games", "1", "--json") == 0
    assert json.loads(capsys.readouterr().out)["player"] == "run"


def test_replays_of_two_maps_or_of_two_players_of_a_name_are_not_added_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ("mine", "MA1")
    record_game("HRL0", "MA1", seed=1, names=names).save(tmp_path / "a.hwr")
    record_game("HRL0", "MA1", Terms(scenario="paddy"), seed=1, names=names).save(tmp_path / "b" / "b.hwr")
    record_game("nearest", "MA1", seed=1, names=names).save(tmp_path / "c" / "c.hwr")

    assert run(str(tmp_path / "a.hwr"), str(tmp_path / "b"), "--player", "mine") == 2
    assert "of several scenarios" in capsys.readouterr().err
    assert run(str(tmp_path / "a.hwr"), str(tmp_path / "c"), "--player", "mine") == 2
    assert "2 players are called 'mine'" in capsys.readouterr().err


WRONG = {
    "two players": (("MA1", "MA2"), "name one player, or replays"),
    "a player and a replay": (("MA1", "{folder}/a.hwr"), "name either one player or replays, not both"),
    "nobody in common": (("{folder}",), "say whose play is counted, --player NAME: the replays have MA1, MA2, nearest"),
    "somebody else": (("{folder}", "--player", "Ann"), "no replay has a player called 'Ann'"),
    "no jobs": (("MA1", "--jobs", "0"), "jobs must be"),
    "no games": (("MA1", "--games", "0"), "games must be at least 1"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_mistake_is_said_in_a_line(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, message = WRONG[what]
    for name, red, blue in (("a", "MA1", "MA2"), ("b", "nearest", "MA2"), ("c", "nearest", "MA1")):
        record_game(red, blue, seed=1).save(tmp_path / f"{name}.hwr")

    assert run(*(one.format(folder=tmp_path) for one in arguments)) == 2
    assert message in capsys.readouterr().err
