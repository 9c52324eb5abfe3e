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
