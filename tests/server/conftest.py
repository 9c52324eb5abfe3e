"""Games of a person without a network, and a live server with a browser's manners."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.maps import load_scenario
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.server.session import Session, Setup, new_session

Json = dict[str, Any]
SECONDS = 30.0  # for what takes a moment


@pytest.fixture
def short() -> Scenario:
    """A scenario of 200 ticks."""
    board = "map plain-40x9\npoint ford 0604 40\nred tank 0204\nblue tank 3904\nticks 200"
    return parse_board(board).scenario


@pytest.fixture
def brief() -> Scenario:
    """Plain, for 300 ticks."""
    return replace(load_scenario("plain"), game_ticks=300)


@pytest.fixture
def begin(tmp_path: Path) -> Callable[..., Session]:
    """Function that begins a game that is kept in the test's folder."""

    def begin(**given: Any) -> Session:
        usual: Json = {"folder": tmp_path, "seed": 3}
        return new_session(Setup(**usual | given))

    return begin


class Browser:
    """What a page does: enters by the token, keeps the cookie, opens a socket, asks and listens."""

    def __init__(self, server: Any, session: Session) -> None:
        import httpx

        self.server, self.session = server, session
        self.host = f"127.0.0.1:{server.guard.port}"
        self.origin = f"http://{self.host}"
        self.http = httpx.Client(base_url=self.origin, headers={"Origin": self.origin}, timeout=SECONDS)

    def enter(self, token: str | None = None) -> int:
        token = self.server.guard.token if token is None else token
        return self.http.post("/enter", content=token).status_code

    @property
    def cookie(self) -> str:
        return "; ".join(f"{name}={value}" for name, value in self.http.cookies.items())

    def socket(self, **headers: str) -> Any:
        """A socket; to be used as a context manager."""
        from websockets.sync.client import connect
        from websockets.typing import Origin

        sent = {"Cookie": self.cookie} | headers
        origin = sent.pop("Origin", self.origin)
        return connect(f"ws://{self.host}/socket", origin=Origin(origin) or None, additional_headers=sent)

    @contextmanager
    def opened(self) -> Iterator[Any]:
        """A socket, after its hello."""
        with self.socket() as socket:
            assert hear(socket)["say"] == "hello"
            yield socket


def hear(socket: Any) -> Json:
    """The next message."""
    return dict(json.loads(socket.recv(timeout=SECONDS)))


def ask(socket: Any, ask: str, number: int = 1, **fields: Any) -> Json:
    """Ask, and wait for the answer; what comes before it is passed over."""
    socket.send(json.dumps({"id": number, "ask": ask, **fields}))
    while (message := hear(socket)).get("to") != number:
        pass
    return message


@pytest.fixture
def tools() -> tuple[Callable[..., Json], Callable[[Any], Json]]:
    """(ask, hear): functions on a socket."""
    return ask, hear


@pytest.fixture
def served() -> Iterator[Callable[[Session], Browser]]:
    """Function that serves a game, in which the clock takes no time."""
    pytest.importorskip("starlette")
    from hexwar_sb3.server.app import Server

    running: list[tuple[Browser, threading.Thread]] = []

    def serve(session: Session, pace: float = 0.0) -> Browser:
        server = Server(session, pace=pace)
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        running.append((Browser(server, session), thread))
        return running[-1][0]

    yield serve
    for browser, thread in running:
        browser.http.close()
        browser.server.stop()
        thread.join(SECONDS)
        assert not thread.is_alive()
