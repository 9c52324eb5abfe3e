"""How long the server of `hexwar play` takes, over whole games and a live socket.

`pytest -s -m slow tests/server/test_speed.py` prints the figures. Bars are of process time, as walls belong to
whoever else uses the machine. Answers count both ends of the socket; a clock at full speed only the server's, whose
threads are not the test's own.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

pytest.importorskip("starlette")
pytest.importorskip("httpx")

from hexwar_sb3.server import room
from hexwar_sb3.server.messages import MOST_SPEED
from hexwar_sb3.server.session import Session

Begin = Callable[..., Session]
Tools = tuple[Callable[..., Any], Callable[[Any], Any]]
ORDER_SECONDS, LOOK_SECONDS = 0.05, 0.05  # 95th percentiles, process time
MOST_SHARE = 0.25  # of a core, while the clock runs as fast as it can

pytestmark = pytest.mark.slow


@dataclass
class Times:
    """Seconds of questions of one kind: on the wall, and of the process."""

    wall: list[float] = field(default_factory=list)
    process: list[float] = field(default_factory=list)

    def take(self, ask: Callable[..., object], *given: object, **fields: object) -> None:
        """Ask, and note how long it took."""
        wall, process = time.perf_counter(), time.process_time()
        ask(*given, **fields)
        self.wall.append(time.perf_counter() - wall)
        self.process.append(time.process_time() - process)

    def figures(self) -> dict[str, float]:
        """Milliseconds."""
        named = {"wall": self.wall, "process": self.process}
        found = {f"{name}_{q}": float(np.percentile(one, q)) for name, one in named.items() for q in (50, 95)}
        return {"n": len(self.wall)} | {name: round(1000 * value, 1) for name, value in found.items()}


def told(name: str, figures: dict[str, Any]) -> None:
    """Print figures, for who wants to see them."""
    sys.stdout.write(f"\n{name}: {json.dumps(figures)}\n")


def server_time() -> float:
    """Process time of all threads but the one that asks."""
    return time.process_time() - time.thread_time()


def until_it_stands(socket: Any, hear: Callable[[Any], Any]) -> Any:
    """The last message of a run."""
    while (message := hear(socket))["say"] != "now" or message["clock"]["running"]:
        pass
    return message


def test_orders_and_questions_are_answered_at_once(
    begin: Begin, served: Callable[..., Any], tools: Tools, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a whole game on "plain": an order until the message that shows it, a look, a way."""
    monkeypatch.setattr(room, "IN_SECONDS", 0.0)  # no number of questions is a flood
    ask, hear = tools
    session = begin(opponent="MA1", seed=5)
    browser, rng = served(session), np.random.default_rng(0)
    cells = np.flatnonzero(session.game.world.cells.playable)
    times = {name: Times() for name in ("look", "thought", "path", "order")}
    browser.enter()

    def order(piece: str, text: str) -> None:
        if ask(socket, "plan", piece=piece, steps=[text], then=False)["say"] == "answer":
            assert piece in hear(socket)["plans"]  # what the page draws

    with browser.opened() as socket:
        while not session.game.over:
            for own in session.game.view("red").own:
                if not own.alive:
                    continue
                piece, cell = own.name, int(rng.choice(cells))
                times["look"].take(ask, socket, "look", piece=piece, at=None)
                times["thought"].take(ask, socket, "look", piece=piece, at=cell)
                fields = {"piece": piece, "to": cell, "from": None}
                times["path"].take(ask, socket, "path", **fields)
                if own.doing in ("settled", "moving") and ask(socket, "path", **fields).get("cells"):
                    goal = f"{piece} go {session.game.roster.cell_name(cell)}"
                    times["order"].take(order, piece, goal)
            ask(socket, "step", to="decision")
            until_it_stands(socket, hear)

    figures = {name: one.figures() for name, one in times.items()}
    told("answers, ms", figures)
    assert figures["order"]["n"] > 50
    assert figures["order"]["process_95"] < 1000 * ORDER_SECONDS
    assert all(figures[name]["process_95"] < 1000 * LOOK_SECONDS for name in ("look", "thought", "path"))


def test_a_clock_at_full_speed_leaves_the_core_to_others(
    begin: Begin, served: Callable[..., Any], tools: Tools
) -> None:
    """A whole game at 64 ticks a second, which it keeps."""
    ask, hear = tools
    session = begin(opponent="MA1", seed=5)
    browser = served(session, pace=1.0)
    browser.enter()
    with browser.opened() as socket:
        ask(socket, "stops", first_sight=False, own_loss=False, idle=False)
        for piece, cell in {
            "tank0": "3635",
            "tank1": "3647",
            "chariot0": "3136",
            "aerocraft0": "3841",
        }.items():
            ask(socket, "plan", piece=piece, steps=[f"{piece} go {cell}"], then=False)
        wall, process = time.perf_counter(), server_time()
        ask(socket, "run", speed=MOST_SPEED)
        last = until_it_stands(socket, hear)
        wall, process = time.perf_counter() - wall, server_time() - process

    assert last["clock"]["over"]
    share = process / wall
    told(
        "at full speed",
        {"wall_s": round(wall, 1), "process_s": round(process, 2), "share_%": round(100 * share, 1)},
    )
    assert wall >= last["clock"]["tick"] / MOST_SPEED - 1
    assert process < MOST_SHARE * last["clock"]["tick"] / MOST_SPEED
