"""GIFs: the ticks that were asked for, small, and of a camp only what it knew."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.viewer.gif import MOST_FRAMES, save_gif


def frames(path: Path) -> int:
    with Image.open(path) as image:
        return int(getattr(image, "n_frames", 1))


def test_a_part_of_a_game_is_a_small_film(replay: Replay, tmp_path: Path) -> None:
    save_gif(replay, tmp_path / "game.gif", 400, 650)

    assert 60 < frames(tmp_path / "game.gif") <= MOST_FRAMES
    assert (tmp_path / "game.gif").stat().st_size < 500_000


def test_a_film_says_which_game_it_is_of(replay: Replay, tmp_path: Path) -> None:
    for view, said in (("referee", f", seed {replay.seed}"), ("red", "")):
        save_gif(replay, tmp_path / "game.gif", 0, 20, view)

        with Image.open(tmp_path / "game.gif") as image:
            assert image.info["comment"].decode() == f"MA1 against MA2, plain, rules 1.0{said}"


@pytest.mark.parametrize("size", ["9x3", "20x11", "90x24", "12x60"])
def test_a_film_of_any_map_is_wide_enough_for_its_caption_and_no_higher_than_wide(
    size: str, tmp_path: Path
) -> None:
    game = Game.from_text(f"map plain-{size}\nred tank 0102\nblue tank 0802\nticks 100")
    game.submit("red", "tank0 move E")
    game.advance(30)
    save_gif(Replay.of(game), tmp_path / "game.gif")

    with Image.open(tmp_path / "game.gif") as image:
        assert image.width == 560
        assert image.height <= 600


def test_a_camps_film_is_the_same_whatever_it_cannot_see(tmp_path: Path) -> None:
    for seed, order in ((1, "tank1 hide"), (2, "tank1 move W")):
        game = Game("plain", seed=seed)
        game.submit("blue", order)
        game.submit("red", "tank0 move E E")
        game.advance(60)
        save_gif(Replay.of(game), tmp_path / f"{seed}.gif", view="red")

    assert (tmp_path / "1.gif").read_bytes() == (tmp_path / "2.gif").read_bytes()


@pytest.mark.parametrize(("start", "until"), [(5, 5), (-1, 3), (0, 11)])
def test_ticks_that_the_game_does_not_have_are_refused(start: int, until: int, tmp_path: Path) -> None:
    game = Game("plain", seed=0)
    game.advance(10)

    with pytest.raises(ConfigError, match=r"expected two ticks of 0\.\.10"):
        save_gif(Replay.of(game), tmp_path / "game.gif", start, until)
    with pytest.raises(UnknownNameError, match="did you mean 'red'"):
        save_gif(Replay.of(game), tmp_path / "game.gif", view="rde")
    assert list(tmp_path.iterdir()) == []
