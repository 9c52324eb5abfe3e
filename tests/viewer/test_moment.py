"""Pictures of one moment: they say which game they are of, and of a camp only what it knew."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.viewer.moment import moment_picture, save_moment
from hexwar_sb3.viewer.scene import scenes


@pytest.fixture(scope="module")
def short() -> Replay:
    game = Game.from_text("map plain-20x11\nred tank 0304\nred tank 0304\nblue tank 0904\nseed 77")
    game.submit("red", "tank0 shoot blue:tank0 GUN")
    game.advance(30)
    return Replay.of(game, PlayerName(name="Ann"), PlayerName(name="$x^$"))


def test_a_picture_says_which_game_and_tick_it_is_of(short: Replay, tmp_path: Path) -> None:
    for name in ("moment.png", "moment.svg", "moment.pdf"):
        save_moment(short, tmp_path / name, 3)

    with Image.open(tmp_path / "moment.png") as image:
        assert image.info["Title"] == "Ann against $x^$, board, rules 1.0, seed 77"
        assert image.info["Description"] == "tick 3"
    drawn = (tmp_path / "moment.svg").read_text(encoding="utf-8")
    assert "<dc:title>Ann against $x^$, board, rules 1.0, seed 77</dc:title>" in drawn
    assert "seed 77" in (tmp_path / "moment.pdf").read_bytes().decode("latin-1")


@pytest.mark.parametrize("name", ["moment.png", "moment.svg", "moment.pdf"])
def test_the_same_moment_gives_the_same_bytes(name: str, short: Replay, tmp_path: Path) -> None:
    for folder in ("one", "other"):
        save_moment(short, tmp_path / folder / name, 3, "red")

    written = (tmp_path / "one" / name).read_bytes()
    assert written == (tmp_path / "other" / name).read_bytes()
    assert b"seed" not in written


@pytest.mark.parametrize("size", ["20x11", "90x24", "12x60"])
def test_nothing_is_cut_on_small_wide_and_high_maps(size: str) -> None:
    game = Game.from_text(f"map plain-{size}\nred tank 0304\nblue tank 0904\nticks 200")
    game.advance(20)
    replay = Replay.of(game)
    (scene,) = scenes(replay, {20})
    figure = moment_picture(replay, scene)
    figure.canvas.draw()
    page = figure.bbox

    for text in (figure._suptitle, figure._supxlabel):  # type: ignore[attr-defined]  # matplotlib has no other way
        box = text.get_window_extent()
        assert page.x0 <= box.x0 < box.x1 <= page.x1
        assert page.y0 <= box.y0 < box.y1 <= page.y1
    (axes,) = figure.axes
    assert axes.get_window_extent().height > 0.6 * page.height


def test_another_tick_and_another_ending_are_refused(short: Replay, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"tick 31; expected one of 0\.\.30"):
        save_moment(short, tmp_path / "moment.png", 31)
    with pytest.raises(ConfigError, match="a picture's name must end in one of"):
        save_moment(short, tmp_path / "moment.jpg", 3)
    assert list(tmp_path.iterdir()) == []
