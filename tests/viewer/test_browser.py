"""The page in a real browser: it opens from a file and in frames, draws what the game says, and asks for nothing."""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.viewer.page import save_page
from hexwar_sb3.viewer.story import CAMPS, VIEWS
from tests.viewer.conftest import PARTED_AT
from tests.viewer.states import mid_fight

VIEWER = Path(__file__).parents[2] / "viewer"
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
NODE = shutil.which("node")

_NEEDED = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium: apt-get install chromium"),
    pytest.mark.skipif(NODE is None, reason="there is no node"),
    pytest.mark.skipif(not (VIEWER / "node_modules").is_dir(), reason="run `make viewer` first"),
]
pytestmark = _NEEDED


def in_a_browser(test: Callable[..., None]) -> Callable[..., None]:
    """A test that needs Node and Chromium; where one of them is missing it is skipped, and says which."""
    for mark in _NEEDED:
        test = mark(test)
    return test


def truth(replay: Replay, count: int, seed: int = 0) -> dict[str, Any]:
    """What the game says at some ticks, in each view."""
    last = replay.end["tick"]
    ticks = {0, last, *random.Random(seed).choices(range(last + 1), k=count)}
    views: dict[str, list[Any]] = {view: [] for view in VIEWS}
    for game, _ in replay.ticks():
        if game.tick in ticks:
            views["referee"].append(_referee(game))
            for camp in CAMPS:
                views[camp].append(_camp(game, camp))
    return {"last": last, "views": views, "fight": mid_fight(replay) - 100}


def _referee(game: Game) -> dict[str, Any]:
    own = {f"{camp}:{piece.name}": piece for camp in CAMPS for piece in game.view(camp).own}
    return {
        "tick": game.tick,
        "margin": {camp: game.margin(camp) for camp in CAMPS},
        "owners": [point.owner for point in game.view("red").points],
        "pieces": [
            [name, piece.cell, piece.blood, int(piece.hidden), int(piece.suppressed), piece.aboard]
            for name, piece in own.items()
        ],
        "sees": [[seer for seer, one in own.items() if name in one.sees] for name in own],
        "beliefs": {camp: _beliefs(game, camp) for camp in CAMPS},
    }


def _camp(game: Game, camp: str) -> dict[str, Any]:
    view = game.view(camp)
    return {
        "tick": game.tick,
        "margin": {camp: view.known_margin},
        "owners": [point.owner for point in view.points],
        "beliefs": {camp: _beliefs(game, camp)},
    }


def _beliefs(game: Game, camp: str) -> list[list[Any]]:
    view = game.view(camp)
    blood = game.world.rules[0].blood
    rows: dict[str, list[Any]] = {one.name: [one.name, "seen", one.cell, one.blood, 0] for one in view.seen}
    rows |= {one.name: [one.name, "lost", one.cell, one.blood, one.unseen_ticks] for one in view.lost}
    for name in game.roster.names:
        if not name.startswith(camp) and name not in rows:
            full = int(blood[game.world.scenario.pieces[game.roster.index(name)].kind])
            rows[name] = [name, "never", None, full, 0]
    return [rows[name] for name in game.roster.names if name in rows]


def run(page: Path, told: dict[str, Any], **env: str) -> subprocess.CompletedProcess[str]:
    facts = page.with_suffix(".json")
    facts.write_text(json.dumps(told))
    return subprocess.run(
        ["node", "e2e/run.mjs", str(page), str(facts)],
        cwd=VIEWER,
        env={**os.environ, "CHROMIUM": str(CHROMIUM), **env},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


def test_the_page_opens_draws_the_truth_and_asks_for_nothing(replay: Replay, tmp_path: Path) -> None:
    page = tmp_path / "game.html"
    save_page(replay, page)

    result = run(page, truth(replay, 60), SPEED=os.environ.get("SPEED", "no"))

    assert result.returncode == 0, result.stderr


def test_a_page_that_draws_something_else_is_found(replay: Replay, tmp_path: Path) -> None:
    page, told = tmp_path / "game.html", truth(replay, 1)
    save_page(replay, page)
    told["views"]["referee"][0]["margin"]["red"] += 1

    result = run(page, told, SPEED="no")

    assert result.returncode == 1
    assert "referee, tick 0, margin" in result.stderr


def test_pages_of_many_games_lead_to_their_games(replay: Replay, pages: dict[str, Path]) -> None:
    """An album, two games side by side with the tick at which they part, and the heat map of a round robin."""
    result = subprocess.run(
        ["node", "e2e/many.mjs", *(str(pages[kind]) for kind in ("album", "compare", "league"))],
        cwd=VIEWER,
        env={**os.environ, "CHROMIUM": str(CHROMIUM), "PARTING": str(first_orders(replay))},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )

    assert result.returncode == 0, result.stderr


def first_orders(replay: Replay) -> int:
    """Tick of the first orders that the parted game lacks."""
    return min(
        line["tick"] for line in replay.lines if line["type"] == "orders" and line["tick"] >= PARTED_AT
    )


@pytest.mark.slow
def test_lines_of_sight_are_the_engines_on_five_maps(tmp_path: Path) -> None:
    from tests.viewer.los_fixture import LARGE, fixture

    path = tmp_path / "los.json"
    path.write_text(json.dumps(fixture(LARGE)))

    result = subprocess.run(
        ["node", "node_modules/vitest/vitest.mjs", "run", "test/los.test.ts"],
        cwd=VIEWER,
        env={**os.environ, "LOS_FIXTURE": str(path)},
        capture_output=True,
        text=True,
        check=False,
    )

    assert result.returncode == 0, result.stdout
