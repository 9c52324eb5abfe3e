"""The sample games are whole and small, and say who played."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.engine.replay import Replay

GAMES = Path(__file__).parents[2] / "examples" / "games"
NAMES = ("blue_against_HRL0", "red_against_MA1", "red_against_MA2")
MOST_BYTES = 16_000


def test_these_are_all() -> None:
    assert sorted(path.stem for path in GAMES.glob("*.hwr")) == list(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_game_can_be_played_again_and_was_a_programs(name: str) -> None:
    path = GAMES / f"{name}.hwr"
    replay = Replay.load(path)
    replay.verify()
    camp, _, opponent = name.split("_")
    players = replay.head["players"]

    assert players.pop(camp) == {"name": "page-driver", "kind": "human", "hints": 0}
    assert [player["name"] for player in players.values()] == [opponent]
    assert replay.end["over"]
    assert path.stat().st_size < MOST_BYTES
