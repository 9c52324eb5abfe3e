"""The table of events (formats/events.md): one row an event, the luck of each shot, and of a camp what it could see."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.known_events import DICE
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.errors import ReplayFileError, UnknownNameError
from hexwar_sb3.viewer.events import COLUMNS, SECRET, event_rows, save_events
from hexwar_sb3.viewer.story import stories


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_table_has_a_row_for_each_event_of_the_replay(replay: Replay, tmp_path: Path) -> None:
    save_events(replay, tmp_path / "events.csv")

    rows = read(tmp_path / "events.csv")
    assert list(rows[0]) == list(COLUMNS)
    assert [(row["tick"], row["kind"], row["piece"]) for row in rows] == [
        (str(event["tick"]), event["kind"], event["piece"]) for event in replay.events
    ]
    assert all(row["camp"] == row["piece"].split(":")[0] for row in rows)


def test_a_value_of_an_event_stands_in_the_column_of_its_name(replay: Replay) -> None:
    for row, event in zip(event_rows(replay), replay.events, strict=True):
        assert all(row[name] == value for name, value in event.items() if name != "type")


def test_a_shot_has_the_luck_that_the_referees_story_says(replay: Replay) -> None:
    told = [event for event in stories(replay)["referee"]["events"] if "lost" in event]
    rows = [row for row in event_rows(replay) if "lost" in row]

    assert len(rows) == len(told) > 10
    for row, event in zip(rows, told, strict=True):
        assert all(row[name] == event[name] for name in ("tick", "piece", "expected", "variance", "lost"))


def test_every_row_says_which_game_it_is_of(replay: Replay) -> None:
    same = {"scenario": "plain", "rules": "1.0", "red": "MA1", "blue": "MA2", "seed": replay.seed}

    assert all(same.items() <= row.items() for row in event_rows(replay))


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_a_camps_table_has_the_events_of_its_own_record_and_no_dice(
    camp: str, replay: Replay, tmp_path: Path
) -> None:
    own = replay.for_camp(camp)
    save_events(replay, tmp_path / "whole.csv", camp)
    save_events(own, tmp_path / "own.csv", camp)

    rows = read(tmp_path / "whole.csv")
    assert {*DICE, "expected", "variance", "lost", "seed"} == SECRET
    assert not SECRET & {*rows[0]}
    assert [(row["tick"], row["piece"]) for row in rows] == [
        (str(event["tick"]), event["piece"]) for event in own.events
    ]
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_another_camps_record_and_an_unknown_view_are_refused(tmp_path: Path) -> None:
    own = Replay.of(Game("plain", seed=0)).for_camp("red")

    with pytest.raises(ReplayFileError, match="found the record of red; expected a whole replay, or blue's"):
        save_events(own, tmp_path / "events.csv", "blue")
    with pytest.raises(UnknownNameError, match="did you mean 'red'"):
        save_events(own, tmp_path / "events.csv", "rde")
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_a_spreadsheet_would_run_is_marked_as_text() -> None:
    game = Game.from_text("map plain-9x3\nred tank 0102\nblue tank 0402\nticks 100")
    game.submit("red", "tank0 move E")
    game.advance(60)
    replay = Replay.of(game, PlayerName(name='=cmd|"/c calc"!A0'), PlayerName(name="b" * 90))

    row = event_rows(replay)[0]

    assert (row["red"], row["blue"]) == ('\'=cmd|"/c calc"!A0', "b" * 40)
