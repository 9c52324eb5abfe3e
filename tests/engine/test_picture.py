"""The picture of a whole game."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import IndirectShoot, Move, Occupy, Shoot
from hexwar_sb3.engine.picture import game_picture, save_game_picture, tell
from hexwar_sb3.engine.replay import Replay


@pytest.fixture(scope="module")
def replay() -> Replay:
    game = Game.from_text("""
        map   plain-20x7
        point main 0504 80
        red   tank 0304
        red   chariot 0102
        blue  soldier 0804 blood 1
        seed  3
    """)
    game.submit("red", [Move("tank0", ["0404", "0504"]), IndirectShoot("chariot0", "1004")], strict=False)
    game.advance(40)
    for _ in range(12):
        game.submit("red", [Occupy("tank0"), Shoot("chariot0", "soldier0", "CANNON")], strict=False)
        game.advance(1)
        game.submit("red", Shoot("tank0", "soldier0", "GUN"), strict=False)
        game.advance(75)
    return Replay.of(game)


def test_the_story_of_a_game_is_told_from_its_replay(replay: Replay) -> None:
    story = tell(replay)
    assert story.paths["red:tank0"] == [["0304", "0404", "0504"]]
    assert [(mark.camp, mark.cell, mark.tick) for mark in story.captures] == [("red", "0504", 41)]
    assert len(story.rounds) == 1
    assert story.shots
    assert [mark.camp for mark in story.deaths] == ["blue"]


def test_the_picture_shows_the_map_and_the_scores(replay: Replay, tmp_path: Path) -> None:
    above, below = game_picture(replay).axes
    assert "seed 3" in above.get_title()
    assert below.get_ylabel() == "margin, points"
    save_game_picture(replay, tmp_path / "game.png")
    assert (tmp_path / "game.png").read_bytes().startswith(b"\x89PNG")


def test_a_point_that_two_pieces_take_at_once_has_its_tick_once() -> None:
    game = Game.from_text("""
        map   plain-20x7
        point main 0504 80
        red   tank 0504
        red   chariot 0504
        blue  soldier 1404
    """)
    game.submit("red", [Occupy("tank0"), Occupy("chariot0")])
    game.advance(20)
    texts = [text.get_text() for text in game_picture(Replay.of(game)).axes[0].texts]

    assert [text for text in texts if text.startswith("red ")] == ["red 1"]
