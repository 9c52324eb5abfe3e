"""A ladder is climbed by wins, its record is a file, and its ratings are of these games alone."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.commands.ladders import open_ladder
from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.players.player import POLICIES, make_player
from hexwar_sb3.server.ladder import Ladder, Played, Rung
from hexwar_sb3.server.messages import Finish
from hexwar_sb3.server.session import Session, resumed_session

RUNGS = (Rung("untrained", "MA1"), Rung("half way", "MA2"), Rung("trained", "HRL0"))
HOME = Path(__file__).parents[2]
PAGE = (HOME / "docs/formats/play.md").read_text(encoding="utf-8")
LEAGUE = HOME / "results/table1/league"


def played(rung: str, result: Any, name: str) -> Played:
    return Played(rung=rung, camp="red", scenario="plain", result=result, margin=5, game=name)


@pytest.fixture
def ladder(tmp_path: Path) -> Ladder:
    return Ladder(RUNGS, tmp_path / "run.ladder.json")


def test_a_win_leads_up_and_the_last_rung_is_the_last(ladder: Ladder) -> None:
    results = [("untrained", "lost"), ("untrained", "drawn"), ("untrained", "won"), ("untrained", "won")]
    results += [("half way", "won"), ("trained", "won"), ("trained", "won")]
    rungs = []
    for number, (rung, result) in enumerate(results):
        ladder.note(played(rung, result, str(number)))
        rungs.append(ladder.at)

    assert rungs == [0, 0, 1, 1, 2, 2, 2]


def test_the_record_is_read_again(ladder: Ladder) -> None:
    ladder.note(played("untrained", "won", "game_1"))
    ladder.note(played("untrained", "lost", "game_1"))  # written already

    again = Ladder(RUNGS, ladder.file)

    assert again.games == ladder.games == [played("untrained", "won", "game_1")]
    section = PAGE.partition("## The record of a ladder")[2].partition("\n## ")[0]
    (game,) = json.loads(ladder.file.read_text())["games"]
    assert {f"`{name}`" for name in game} <= set(section.split())


def test_who_wins_is_rated_above_whom_he_beats(ladder: Ladder) -> None:
    assert ladder.told() | {"rungs": []} == {"rungs": [], "rung": 0, "elo": None, "elo_range": None}
    for number in range(6):
        ladder.note(played("untrained", "won" if number else "lost", str(number)))

    told = ladder.told()
    first, second, _ = told["rungs"]

    assert (first["name"], first["won"], first["games"]) == ("untrained", 5, 6)
    assert told["elo"] > 1500 > first["elo"]
    assert told["elo_range"][0] < told["elo"] < told["elo_range"][1]
    assert (second["games"], second["elo"]) == (0, None)


def test_broken_records_are_refused(ladder: Ladder, bad: Callable[[Any], Iterator[bytes]]) -> None:
    ladder.note(played("untrained", "won", "game_1"))
    for text in bad(json.loads(ladder.file.read_text())):
        ladder.file.write_bytes(text)
        with suppress(FileFormatError):
            assert Ladder(RUNGS, ladder.file).at in range(3)


def test_a_ladder_has_rungs(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="without opponents"):
        Ladder((), tmp_path / "x")


def test_a_game_counts_at_its_end(ladder: Ladder, begin: Callable[..., Session], short: Scenario) -> None:
    session = begin(ladder=ladder, scenario=short, opponent="MA1")
    assert session.hello()["opponent"] == "untrained"
    assert session.hello()["ladder"]["rung"] == 0
    session.answer(Finish())
    while session.clock.running:
        session.advance()

    (game,) = Ladder(RUNGS, ladder.file).games
    assert (game.rung, game.game, game.camp) == ("untrained", "game", "red")
    assert session.over()["ladder"]["rungs"][0]["games"] == 1


def test_a_game_that_goes_on_counts_on_its_ladder_alone(
    ladder: Ladder, begin: Callable[..., Session], short: Scenario
) -> None:
    session = begin(ladder=ladder, scenario=short, opponent="MA1")
    session.close()
    file = session.setup.folder / "game.partial.hwr"

    with pytest.raises(HexWarError, match="MA1 is on no rung"):
        resumed_session(file, Ladder(RUNGS[1:], ladder.file))
    again = resumed_session(file, ladder)
    assert again.hello()["opponent"] == "untrained"
    again.close()


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run folder with what a training leaves of policies."""
    names = ["untrained", "policy", *(f"snapshots/{steps:09d}" for steps in range(0, 90_000, 10_000))]
    for name in names:
        shutil.copytree(POLICIES["HRL0"], tmp_path / "commander_1" / name)
    return tmp_path / "commander_1"


def test_a_training_is_a_ladder(run: Path, tmp_path: Path) -> None:
    ladder = open_ladder(run, "blue", tmp_path / "play")

    assert [rung.name for rung in ladder.rungs] == [
        *(
            "untrained",
            "10,000 steps",
            "20,000 steps",
            "40,000 steps",
            "60,000 steps",
            "80,000 steps",
            "trained",
        )
    ]
    assert ladder.file == tmp_path / "play" / "commander_1.ladder.json"
    assert Path(ladder.rungs[-1].player) == run / "policy"


@pytest.fixture
def league(tmp_path: Path) -> Path:
    """The league of table 1, whose iterations have one policy for all their models."""
    place = shutil.copytree(LEAGUE, tmp_path / "league")
    for table in place.glob("iteration_*/table.json"):
        for name in (name for camp in json.loads(table.read_text())["kept"].values() for name in camp):
            if name[0].isdigit():
                home = place / f"iteration_{int(name.split('-')[0]):02d}" / "groups" / name / "both"
                shutil.copytree(POLICIES["HRL0"], home, dirs_exist_ok=True)
    return place


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_a_league_is_a_ladder(camp: str, league: Path, tmp_path: Path) -> None:
    ladder = open_ladder(league, camp, tmp_path)

    assert [rung.name.split(":")[0] for rung in ladder.rungs] == [f"iteration {k}" for k in range(11)]
    assert all(hasattr(make_player(rung.player), "act") for rung in ladder.rungs)
    assert ladder.rung_of(ladder.rungs[-1].player) is ladder.rungs[-1]


def test_who_stays_the_best_is_one_rung(league: Path, tmp_path: Path) -> None:
    first, second = (league / f"iteration_{k:02d}" / "table.json" for k in (0, 1))
    found, kept = json.loads(second.read_text()), json.loads(first.read_text())["kept"]
    second.write_text(json.dumps({**found, "kept": kept}))

    names = [rung.name for rung in open_ladder(league, "red", tmp_path).rungs]
    assert names[0].startswith("iteration 0: ")
    assert names[1].startswith("iteration 2: ")


def test_models_that_are_gone_are_no_rungs(tmp_path: Path) -> None:
    """results/ keeps the models that the league of table 1 began with."""
    names = [rung.name for rung in open_ladder(LEAGUE, "red", tmp_path).rungs]
    assert names == ["iteration 0: default-2", "iteration 1: default-1"]


def test_a_folder_without_policies_is_none(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no policies; expected the folder of a training or of a league"):
        open_ladder(tmp_path, "red", tmp_path)
