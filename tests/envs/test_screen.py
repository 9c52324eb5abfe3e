"""Windows and films of games."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordVideo

from hexwar_sb3.envs.registration import ENVS
from hexwar_sb3.envs.screen import Screen
from hexwar_sb3.errors import ConfigError, UnknownNameError

FRAME = np.arange(6 * 4 * 3, dtype=np.uint8).reshape(6, 4, 3)  # height, width, RGB


@pytest.fixture
def pygame(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A window that is nowhere to be seen, and does not wait."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setattr("hexwar_sb3.envs.screen.FPS", 1000)
    return pytest.importorskip("pygame", reason="the extra human is not installed")


def test_the_window_shows_the_frame(pygame: Any) -> None:
    screen = Screen("human", lambda: FRAME, "a game")
    screen.follow()
    shown = pygame.surfarray.array3d(pygame.display.get_surface())
    assert np.array_equal(shown.swapaxes(0, 1), FRAME)
    assert pygame.display.get_caption()[0] == "a game"
    screen.close()
    assert not pygame.display.get_init()
    screen.close()  # nothing is left to close


@pytest.mark.parametrize("env_id", ENVS)
def test_a_window_follows_reset_and_step(env_id: str, pygame: Any) -> None:
    env = gymnasium.make(env_id, render_mode="human", disable_env_checker=True)
    env.reset(seed=0)
    first = pygame.surfarray.array3d(pygame.display.get_surface()).copy()
    for _ in range(10):
        env.step(env.action_space.sample())
    later = pygame.surfarray.array3d(pygame.display.get_surface()).copy()
    assert not np.array_equal(first, later)  # the clock in the title alone goes on
    assert env.render() is None
    env.close()
    assert not pygame.display.get_init()


@pytest.mark.usefixtures("pygame")
@pytest.mark.parametrize("env_id", ENVS)
def test_gymnasium_finds_nothing_wrong_with_any_mode(env_id: str) -> None:
    check_env(gymnasium.make(env_id).unwrapped)


def test_without_pygame_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(ConfigError, match=r"pip install 'hexwar-sb3\[human\]'"):
        Screen("human", lambda: FRAME, "a game")


def test_modes() -> None:
    assert Screen("rgb_array", lambda: FRAME, "a game").render() is FRAME
    assert Screen(None, lambda: FRAME, "a game").render() is None
    with pytest.raises(UnknownNameError, match="unknown render_mode 'ansi'"):
        Screen("ansi", lambda: FRAME, "a game")


def test_gymnasiums_wrapper_makes_a_film(tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="the extra video is not installed")
    env = gymnasium.make("HexWarTask-v0", render_mode="rgb_array", decision_ticks=600)
    env = RecordVideo(env, str(tmp_path / "films"), disable_logger=True)
    env.reset(seed=0)
    over = False
    while not over:
        _, _, over, _, _ = env.step(env.action_space.sample())
    env.close()  # type: ignore[no-untyped-call]
    (film,) = (tmp_path / "films").glob("*.mp4")
    assert film.stat().st_size > 1_000
