"""States of the pages that a reader of docs/watch.md sees, found in whatever games there are: for pictures and tests.

`viewer/e2e/states.mjs` opens them in a browser and looks whether anything overlaps or is cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.replay import Replay

Json = dict[str, Any]
FIRE = frozenset({"shot", "guided", "close_shot", "exit_shot", "mortar_judged"})
SHOWN_TICKS = 14  # that fire stays on the map
EVERY = 25  # ticks between two looks for ghosts


def mid_fight(replay: Replay) -> int:
    """The tick at which most fire is on the map, the earliest one."""
    shots = [line["tick"] for line in replay.lines if line["type"] == "event" and line["kind"] in FIRE]
    return max(shots, key=lambda tick: (sum(tick - SHOWN_TICKS < one <= tick for one in shots), -tick))


def most_ghosts(replay: Replay, camp: str = "red") -> int:
    """A tick at which a camp has lost many enemies from sight, and sees one."""
    found = (-1, 0)
    for game, _ in replay.ticks():
        if game.tick % EVERY == 0:
            view = game.view(camp)
            lost = sum(one.blood > 0 for one in view.lost)
            found = max(found, (lost if view.seen else 0, -game.tick))
    return -found[1]


def someone(replay: Replay, tick: int) -> str:
    """A red piece that is on the map at a tick."""
    game = replay.game_at(tick)
    return next(f"red:{one.name}" for one in game.view("red").own if one.alive and one.aboard is None)


def states(replay: Replay, pages: Mapping[str, Path]) -> list[Json]:
    """The six states of the guide, and two games side by side.

    Args:
        replay: the game of the page `game`.
        pages: `game`, `album`, `league`, and if there is one `compare`, of two games.
    """
    page = {name: str(path.resolve()) for name, path in pages.items()}
    fight, ghosts = mid_fight(replay), most_ghosts(replay)
    log = {"click": ["#tab-log"], "press": ["z"]}
    found: list[Json] = [
        {"name": "referee", "hash": f"#t={fight}", "click": ["#tab-log", "#on-los"], "press": ["z"]},
        {"name": "red", "hash": f"#t={ghosts}&view=red", **log},
        {
            "name": "policy",
            "hash": f"#t={fight}&pick={someone(replay, fight)}",
            "click": ["#tab-policy"],
            "press": ["z"],
        },
        {"name": "album", "page": page["album"]},
        {"name": "league", "page": page["league"]},
        {"name": "phone", "hash": f"#t={fight}"},
    ]
    if "compare" in page:
        pair = {"page": page["compare"], "hash": f"#game=1&with=2&t={fight}"}
        found += [{"name": "pair", **pair}, {"name": "pair-panel", **pair, "click": ["#tab-log"]}]
    shown = {"phone": "phone"}
    return [
        {"page": page["game"], "picture": shown.get(state["name"], "desktop"), **state} for state in found
    ]
