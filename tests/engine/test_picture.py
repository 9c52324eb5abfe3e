"""The picture of a whole game."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.margins import margins
from hexwar_sb3.engine.orders import IndirectShoot, Move, Occupy, Shoot
from hexwar_sb3.engine.picture import game_picture, save_game_picture, tell
from hexwar_sb3.engine.replay import PlayerName, Replay


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
    figure = game_picture(replay)
    _, _, below = figure.axes
    assert (
        figure.get_suptitle()
        == "board: unknown (red) against unknown (blue)\nat tick 952; margin red +131, blue -131; rules 1.0"
    )
    assert below.get_ylabel() == "points"
    save_game_picture(replay, tmp_path / "game.png")
    assert (tmp_path / "game.png").read_bytes().startswith(b"\x89PNG")


def test_a_name_is_text_and_no_formula(tmp_path: Path) -> None:
    named = Replay.of(Game("plain", seed=0), PlayerName(name="$\\frac{$"), PlayerName(name="x" * 90))

    save_game_picture(named, tmp_path / "game.svg")

    assert f"{'x' * 40} (blue)\n" in game_picture(named).get_suptitle()


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


@pytest.mark.parametrize("size", ["20x11", "90x24", "12x60"])
def test_the_page_is_as_wide_and_high_as_the_map_and_nothing_is_cut(size: str) -> None:
    game = Game.from_text(f"map plain-{size}\nred tank 0304\nblue tank 0904\nticks 200")
    game.advance(200)
    figure = game_picture(Replay.of(game))
    figure.canvas.draw()
    above, legend, below = figure.axes
    page = figure.bbox

    for axes in (above, legend, below):
        box = axes.get_tightbbox()
        assert box is not None
        assert page.x0 <= box.x0 < box.x1 <= page.x1
    assert above.get_window_extent().height > 0.4 * (
        page.height - 3.3 * figure.dpi
    )  # not half of it is white
    words = legend.get_legend()
    assert words is not None
    assert page.x0 <= words.get_window_extent().x0 < words.get_window_extent().x1 <= page.x1


@pytest.mark.parametrize("name", ["plain", "hills"])
def test_margins_step_where_their_causes_are(name: str) -> None:
    """At every tick they are those of the game that is played again."""
    replay = Replay.load(Path(__file__).with_name("replays_of_version_1") / f"{name}.hwr")
    found, game = margins(replay), Game(replay.scenario(), replay.seed)
    acts = [line for line in replay.lines if line["type"] == "orders"]
    for tick in range(replay.end["tick"] + 1):
        for camp, steps in found.items():
            assert [value for at, value in steps if at <= tick][-1] == game.margin(camp), (tick, camp)
        for line in acts:
            if line["tick"] == tick:
                game.submit(line["camp"], line["orders"], strict=False)
        game.advance(1)
    assert all(len({at for at, _ in steps}) == len(steps) > 3 for steps in found.values())
