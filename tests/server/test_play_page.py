"""The page of `hexwar play` in a real browser, against the real server: whole games by mouse, by keys, in two tabs, on a phone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from hexwar_sb3.engine.replay import Replay

pytest.importorskip("uvicorn", reason="pip install 'hexwar_sb3[play]'")

VIEWER = Path(__file__).parents[2] / "viewer"
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
PICTURES = os.environ.get("PICTURES")  # folder, for the pictures of docs/play

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


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Where a new short game is played."""
    from hexwar_sb3.server.app import Server
    from hexwar_sb3.server.session import Session, Setup

    scenario = tmp_path / "short.scenario.json"
    scenario.write_text(json.dumps(SHORT))
    session = Session(Setup(scenario=scenario, seed=3, name="evening", folder=tmp_path))
    server = Server(session)
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server.guard.address
    server.stop()
    thread.join(timeout=20)
    if session.replay is not None:
        session.replay.save(tmp_path / "evening.hwr")


def browse(address: str, mode: str) -> subprocess.CompletedProcess[str]:
    pictures = [PICTURES] if PICTURES else []
    return subprocess.run(
        ["node", "e2e/play.mjs", address, mode, *pictures],
        cwd=VIEWER,
        env={**os.environ, "CHROMIUM": str(CHROMIUM)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@pytest.mark.parametrize("mode", ["mouse", "keys", "tabs", "phone"])
def test_a_person_plays(mode: str, address: str) -> None:
    """By mouse and by keys to the end, with a capture; in two tabs and on a phone as far as they differ."""
    result = browse(address, mode)

    print(result.stdout)
    assert result.returncode == 0, result.stderr
