"""The page of `hexwar play` in a real browser, against the real server: whole games by mouse, by keys, in two tabs, on a phone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from PIL import Image

from hexwar_sb3.cli import main
from hexwar_sb3.engine.replay import Replay

if TYPE_CHECKING:
    from hexwar_sb3.server.app import Server
    from hexwar_sb3.server.session import Session

pytest.importorskip("uvicorn", reason="pip install 'hexwar_sb3[play]'")

VIEWER = Path(__file__).parents[2] / "viewer"
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
PICTURES = os.environ.get("PICTURES")  # folder; PICTURES=docs/play makes the pictures of the guide
MOST_PICTURE_BYTES = 120_000
NASTY = "<img src=x onerror=alert(1)>&lt;b> Zoë"
SAMPLES = os.environ.get("SAMPLES")  # folder; SAMPLES=examples/games makes the sample games

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium: apt-get install chromium"),
    pytest.mark.skipif(shutil.which("node") is None, reason="there is no node"),
    pytest.mark.skipif(not (VIEWER / "node_modules").is_dir(), reason="run `make viewer` first"),
]

SHORT = {
    "format": "hexwar-scenario",
    "version": 1,
    "name": "short",
    "map": "plain",
    "game_ticks": 240,
    "points": [{"name": "main", "cell": "3635", "value": 80}],
    "pieces": [
        {"camp": "red", "name": "tank0", "kind": "tank", "cell": "3335"},
        {"camp": "red", "name": "chariot0", "kind": "chariot", "cell": "3035"},
        {"camp": "blue", "name": "tank0", "kind": "tank", "cell": "5435"},
        {"camp": "blue", "name": "soldier0", "kind": "soldier", "cell": "4135"},
    ],
}


@contextmanager
def served(session: Session) -> Iterator[Server]:
    """A server whose clock takes its time."""
    from hexwar_sb3.server.app import Server

    server = Server(session)
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server
    server.stop()
    thread.join(timeout=20)


@pytest.fixture
def server(begin: Callable[..., Session], tmp_path: Path) -> Iterator[Server]:
    """Of a new short game."""
    scenario = tmp_path / "short.scenario.json"
    scenario.write_text(json.dumps(SHORT))
    with served(begin(scenario=scenario, name="evening", player=NASTY)) as server:
        yield server


def browser(address: str, mode: str, **more: str) -> subprocess.Popen[str]:
    """A browser at an address; what it prints can be read."""
    pictures = [] if PICTURES is None else [str(Path(PICTURES).resolve())]
    command = ["node", "e2e/play.mjs", address, mode, *pictures]
    env = {**os.environ, "CHROMIUM": str(CHROMIUM), "SPEED": os.environ.get("SPEED", "no"), **more}
    pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=VIEWER, env=env, text=True, **pipes)


@pytest.mark.parametrize("mode", ["mouse", "keys"])
def test_a_whole_game_is_played(mode: str, server: Server) -> None:
    """By mouse alone and by keys alone, with a capture; and its replay is a game."""
    process = browser(server.guard.address, mode)
    _, problems = process.communicate(timeout=300)

    assert process.returncode == 0, problems
    with pytest.raises(SystemExit) as end:
        main(("watch", str(server.session.file), "--verify"))
    assert end.value.code == 0
    assert Replay.load(server.session.file).head["players"]["red"]["name"] == NASTY


@pytest.mark.parametrize("mode", ["tabs", "phone"])
def test_other_tabs_and_other_screens(mode: str, server: Server) -> None:
    """A second tab reads along and takes over, a closed one pauses; a thumb finds everything on a phone."""
    process = browser(server.guard.address, mode)
    _, problems = process.communicate(timeout=120)

    assert process.returncode == 0, problems


def test_a_server_that_is_gone_is_told(server: Server) -> None:
    process = browser(server.guard.address, "lost")
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"

    server.stop()

    _, problems = process.communicate(timeout=120)
    assert process.returncode == 0, problems


@pytest.mark.skipif(PICTURES is None, reason="PICTURES=docs/play makes them")
@pytest.mark.parametrize("mode", ["guide", "guide-phone"])
def test_the_pictures_of_the_guide(mode: str, begin: Callable[..., Session]) -> None:
    """The same game gives the same pictures; they are small."""
    with served(begin(scenario="plain", seed=5, name="evening")) as server:
        process = browser(server.guard.address, mode)
        _, problems = process.communicate(timeout=300)

    assert process.returncode == 0, problems
    for path in Path(str(PICTURES)).glob("*.png"):
        image = Image.open(path).convert("RGB")
        image.quantize(240, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)
        assert path.stat().st_size < MOST_PICTURE_BYTES


GOALS = {  # of red's pieces on "plain": all of them near the main point
    "tank0": "3635",
    "tank1": "3436",
    "chariot0": "3334",
    "chariot1": "3336",
    "soldier0": "3535",
    "soldier1": "3536",
    "aerocraft0": "3438",
}


def mirrored(goals: dict[str, str]) -> dict[str, str]:
    """The same for blue."""
    return {piece: f"{72 - int(cell[:2])}{cell[2:]}" for piece, cell in goals.items()}


@pytest.mark.skipif(SAMPLES is None, reason="SAMPLES=examples/games makes them")
@pytest.mark.parametrize(
    ("name", "side", "opponent", "seed"),
    [
        ("red_against_MA1", "red", "MA1", 1),
        ("red_against_MA2", "red", "MA2", 1),
        ("blue_against_HRL0", "blue", "HRL0", 3),
    ],
)
def test_the_sample_games(
    name: str, side: str, opponent: str, seed: int, begin: Callable[..., Session]
) -> None:
    """Whole games that a program plays on the page, and it is no person's name that they bear."""
    session = begin(player="page-driver", name=name, side=side, opponent=opponent, seed=seed)
    with served(session) as server:
        goals = json.dumps(GOALS if side == "red" else mirrored(GOALS))
        process = browser(server.guard.address, "sample", GOALS=goals)
        _, problems = process.communicate(timeout=3_600)

    assert process.returncode == 0, problems
    shutil.copy(session.file, Path(str(SAMPLES)))
