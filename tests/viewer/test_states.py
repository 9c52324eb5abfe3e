"""In the states that the guide shows nothing overlaps and nothing is cut, on a desktop and on a phone."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.viewer.page import save_page
from tests.viewer.states import FIRE, SHOWN_TICKS, mid_fight, most_ghosts, someone, states
from tests.viewer.test_browser import CHROMIUM, VIEWER, in_a_browser

Json = dict[str, Any]

# what is done to an element, and what is then found
SPOILED = (
    ("#what", "position: fixed; left: 240px; top: 8px", "in #what"),
    ("#tab-log", "flex: none; min-width: 0; width: 12px; overflow: hidden", 'cut: "Log" in #tab-log'),
    ("#layers", "top: 0; right: 0; bottom: 0", "lies over token"),
    ("#stage", "margin-left: -400px", 'cut: "Beliefs" in #on-beliefs'),
    ("#track", "transform: scaleX(1.1)", "cut: "),
)


def look(found: list[Json], folder: Path) -> subprocess.CompletedProcess[str]:
    told = folder / "states.json"
    told.write_text(json.dumps(found))
    return subprocess.run(
        ["node", "e2e/states.mjs", str(told)],
        cwd=VIEWER,
        env={**os.environ, "CHROMIUM": str(CHROMIUM)},
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )


@pytest.fixture(scope="module")
def found(replay: Replay, pages: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> list[Json]:
    game = tmp_path_factory.mktemp("game") / "game.html"
    save_page(replay, game)
    return states(replay, {**pages, "game": game})


@in_a_browser
def test_nothing_overlaps_and_nothing_is_cut(found: list[Json], tmp_path: Path) -> None:
    result = look(found, tmp_path)

    assert (result.returncode, result.stderr) == (0, "")


@in_a_browser
def test_what_is_spoiled_is_found(found: list[Json], tmp_path: Path) -> None:
    referee = next(state for state in found if state["name"] == "referee")
    spoiled = [
        {**referee, "name": f"spoiled {k}", "sizes": ["desktop"], "spoil": {place: f"; {style}"}}
        for k, (place, style, _) in enumerate(SPOILED)
    ]

    result = look(spoiled, tmp_path)

    assert result.returncode == 1
    for k, (_, _, said) in enumerate(SPOILED):
        lines = [line for line in result.stderr.splitlines() if line.startswith(f"spoiled {k},")]
        assert any(said in line for line in lines), (k, lines)


def test_a_fight_is_where_most_fire_is(replay: Replay) -> None:
    shots = [line["tick"] for line in replay.lines if line["type"] == "event" and line["kind"] in FIRE]
    shown = {
        tick: sum(tick - SHOWN_TICKS < one <= tick for one in shots) for tick in range(replay.end["tick"])
    }

    assert shown[mid_fight(replay)] == max(shown.values()) > 1


def test_ghosts_and_pieces_are_there(replay: Replay) -> None:
    tick = most_ghosts(replay)
    view = replay.game_at(tick).view("red")

    assert view.seen
    assert any(one.blood > 0 for one in view.lost)
    assert someone(replay, tick).startswith("red:")
