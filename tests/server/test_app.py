"""The table of bad input against a live server on loopback: each gets its answer, and the game goes on."""

from __future__ import annotations

import asyncio
import json
import logging
import socket as plain
import time
from collections.abc import Callable
from contextlib import ExitStack
from itertools import pairwise
from typing import Any

import pytest

pytest.importorskip("starlette")
httpx = pytest.importorskip("httpx")

from websockets.exceptions import ConnectionClosed, InvalidStatus  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from hexwar_sb3.maps.scenario import Scenario  # noqa: E402
from hexwar_sb3.server import app as app_module  # noqa: E402
from hexwar_sb3.server import room as room_module  # noqa: E402
from hexwar_sb3.server.room import Room  # noqa: E402
from hexwar_sb3.server.session import Session  # noqa: E402

Begin = Callable[..., Session]
Serve = Callable[..., Any]
Tools = tuple[Callable[..., Any], Callable[[Any], Any]]
SECONDS = 30.0


def closed_with(socket: Any) -> int:
    """The code that a socket is closed with; what is said before is passed over."""
    try:
        while True:
            socket.recv(timeout=SECONDS)
    except ConnectionClosed as end:
        return 0 if end.rcvd is None else int(end.rcvd.code)


@pytest.fixture
def browser(begin: Begin, served: Serve) -> Any:
    """A browser that has entered."""
    found = served(begin())
    assert found.enter() == 204
    return found


# --- pages ---------------------------------------------------------------------------------------


def test_a_game_from_hello_to_the_page_after_it(
    begin: Begin, served: Serve, brief: Scenario, tools: Tools
) -> None:
    ask, hear = tools
    browser = served(begin(scenario=brief))
    browser.enter()
    assert browser.http.get("/").status_code == 200
    assert browser.http.get("/rules").text.startswith("<!doctype html>")
    assert browser.http.get("/after").status_code == browser.http.get("/replay").status_code == 403
    with browser.opened() as socket:
        plan = {"piece": "tank0", "steps": ["tank0 go 1234"], "then": False}
        assert ask(socket, "plan", 7, **plan) == {"say": "answer", "to": 7}
        assert hear(socket)["tray"] == {"tank0": "tank0 move 1235 1234"}
        ask(socket, "finish", 8)
        while (message := hear(socket))["say"] != "over":
            assert message["say"] == "now"
    replay = browser.http.get("/replay")
    assert replay.content == browser.session.file.read_bytes()
    assert 'filename="game.hwr"' in replay.headers["content-disposition"]
    after = browser.http.get("/after")
    assert "story-1-referee" in after.text
    for answer in (after, browser.http.get("/"), browser.http.get("/rules")):
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; ")
        assert "unsafe" not in policy
        assert "access-control-allow-origin" not in answer.headers


def test_step_and_run_and_pause(browser: Any, tools: Tools) -> None:
    ask, hear = tools
    with browser.opened() as socket:
        ask(socket, "step", 1, to="decision")
        ticks = [hear(socket)["clock"] for _ in range(6)]
        assert [clock["tick"] for clock in ticks] == [0, 16, 32, 48, 64, 75]
        assert [clock["running"] for clock in ticks] == [True, True, True, True, True, False]
        ask(socket, "run", 2, speed=64)
        assert ask(socket, "pause", 3) == {"say": "answer", "to": 3}
        assert hear(socket)["clock"]["running"] is False


# --- who may -------------------------------------------------------------------------------------


def test_without_the_cookie_nothing_is_answered(begin: Begin, served: Serve) -> None:
    browser = served(begin())
    for path in ("/rules", "/after", "/replay", "/enter", "/socket", "/nowhere", "/built/page.html"):
        assert browser.http.get(path).status_code == 403, path
    assert browser.enter("wrong") == 403
    assert browser.enter("") == 403
    with pytest.raises(InvalidStatus, match="403"), browser.socket():
        pass


def test_the_token_is_good_once(begin: Begin, served: Serve) -> None:
    browser = served(begin())
    assert browser.enter() == 204
    assert browser.enter() == 204  # it has the cookie now
    again = httpx.post(
        f"{browser.origin}/enter", content=browser.server.guard.token, headers={"Origin": browser.origin}
    )
    assert again.status_code == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", ""])
def test_another_origin_is_refused(browser: Any, origin: str) -> None:
    headers = {"Origin": origin}
    assert browser.http.post("/enter", content=browser.server.guard.token, headers=headers).status_code == 403
    with pytest.raises(InvalidStatus, match="403"), browser.socket(Origin=origin):
        pass


def test_another_host_is_refused(browser: Any) -> None:
    for host in ("127.evil.example", f"evil.example:{browser.server.guard.port}", "127.0.0.1"):
        assert browser.http.get("/", headers={"Host": host}).status_code == 403
        assert browser.http.get("/rules", headers={"Host": host}).status_code == 403


def test_a_small_message_does_not_wait_until_the_one_before_it_is_acknowledged(
    begin: Begin, served: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An order is answered by two; without this the second one, which is drawn, comes 40 ms later."""
    found, connection_made = [], app_module.BriefConnection.connection_made

    def noted(connection: Any, transport: Any) -> None:
        connection_made(connection, transport)
        found.append(transport.get_extra_info("socket").getsockopt(plain.IPPROTO_TCP, plain.TCP_NODELAY))

    monkeypatch.setattr(app_module.BriefConnection, "connection_made", noted)
    assert served(begin()).enter() == 204
    assert found
    assert all(found)


def test_the_server_listens_on_this_machine_alone(browser: Any) -> None:
    assert browser.server.listener.getsockname()[0] == "127.0.0.1"


def test_nothing_is_logged_of_the_token(
    begin: Begin, served: Serve, caplog: pytest.LogCaptureFixture, capfd: Any
) -> None:
    caplog.set_level(logging.DEBUG)
    browser = served(begin())
    browser.enter("wrong")
    browser.enter()
    with browser.opened():
        pass
    out, err = capfd.readouterr()
    secrets = (browser.server.guard.token, browser.cookie.partition("=")[2])
    shown = (
        out
        + err
        + "".join(record.getMessage() for record in caplog.records if record.name.startswith("uvicorn"))
    )
    assert not any(secret in shown for secret in secrets)


# --- how much ------------------------------------------------------------------------------------


def test_a_long_body_is_refused_before_it_is_read(browser: Any) -> None:
    with plain.create_connection(("127.0.0.1", browser.server.guard.port), SECONDS) as raw:
        head = f"POST /enter HTTP/1.1\r\nHost: {browser.host}\r\nOrigin: {browser.origin}\r\nContent-Length: 1000000000\r\n\r\n"
        raw.sendall(head.encode())
        assert raw.recv(100).startswith(b"HTTP/1.1 413")


def test_a_long_body_that_does_not_say_so_is_refused(browser: Any) -> None:
    def body() -> Any:
        for _ in range(100):
            yield b"x" * 1000

    assert browser.http.post("/enter", content=body()).status_code == 413


def test_a_long_message_closes_the_socket(browser: Any) -> None:
    with browser.opened() as socket:
        socket.send("x" * 16_385)
        assert closed_with(socket) == 1009
    with browser.opened():
        pass  # and the game goes on


@pytest.mark.parametrize("length", [16_385, 1_000_000, 2**40])
def test_a_message_that_is_to_be_long_closes_the_socket_before_it_comes(browser: Any, length: int) -> None:
    with browser.opened() as socket:
        socket.socket.sendall(
            b"\x81\xff" + length.to_bytes(8, "big") + bytes(4)
        )  # a text, its length, its mask
        assert closed_with(socket) == 1009
    with browser.opened():
        pass  # and the game goes on


def test_a_message_of_the_greatest_length_is_read(browser: Any, tools: Tools) -> None:
    ask, _ = tools
    with browser.opened() as socket:
        step = "tank0 move" + " E" * 8_100
        said = ask(socket, "plan", piece="tank0", steps=[step], then=False)
    assert said["say"] == "refusal"
    assert len(said["why"]) <= 1_000


def test_a_flood_closes_the_socket(browser: Any) -> None:
    with browser.opened() as socket:
        for _ in range(60):
            socket.send('{"id": 1, "ask": "pause"}')
        assert closed_with(socket) == 1008
    with browser.opened():
        pass


def test_a_connection_that_says_nothing_is_closed(
    begin: Begin, served: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app_module, "CONNECTION_SECONDS", 0.2)
    monkeypatch.setattr(app_module, "BODY_SECONDS", 0.2)
    browser = served(begin())
    asks = ("", f"GET / HTTP/1.1\r\nHost: {browser.host}\r\n", "x")
    for text in asks:
        with plain.create_connection(("127.0.0.1", browser.server.guard.port), SECONDS) as raw:
            raw.sendall(text.encode())
            while raw.recv(1000):
                pass
    body = f"POST /enter HTTP/1.1\r\nHost: {browser.host}\r\nOrigin: {browser.origin}\r\nContent-Length: 10\r\n\r\nab"
    with plain.create_connection(("127.0.0.1", browser.server.guard.port), SECONDS) as raw:
        raw.sendall(body.encode())
        assert raw.recv(1000).startswith(b"HTTP/1.1 413")


def test_a_socket_outlives_other_connections(
    begin: Begin, served: Serve, tools: Tools, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app_module, "CONNECTION_SECONDS", 0.1)
    browser = served(begin())
    browser.enter()
    ask, _ = tools
    with browser.opened() as socket:
        time.sleep(0.3)
        assert ask(socket, "pause")["say"] == "answer"


# --- what is asked -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('{"id": 1, "ask": "plan", "piece": "blue:tank0", "steps": ["blue:tank0 hide"], "then": false}', "not belong to red"),
        ('{"id": 1, "ask": "plan", "piece": "tank0", "steps": ["blue:tank0 hide"], "then": false}', "a step of tank0"),
        ('{"id": 1, "ask": "plan", "piece": "tank0", "steps": ["tank0 go 9999"], "then": false}', "9999"),
        ('{"id": 1, "ask": "plan", "piece": "tank0", "steps": ["tank0 hide"], "then": false, "tick": 0}', "unknown setting"),
        ('{"id": 1, "ask": "look", "piece": "tank0", "at": 1000000000}', "expected a playable cell"),
        ('{"id": 1, "ask": "path", "piece": "tank0", "to": -5, "from": null}', "expected a playable cell"),
        ('{"id": 1, "ask": "run", "speed": 1000000000}', "1..64"),
        ('{"id": 1, "ask": "hint", "piece": "tank0"}', "no policy"),
        ('{"id": 1, "ask": "undo"}', "nothing to take back"),
        ('{"id": 1, "ask": "end"}', "one of look"),
        ("not JSON", "JSON"),
        ('{"id": 1, "ask": "plan", "piece": "tank0", "steps": [' + ", ".join(['"tank0 hide"'] * 1000) + '], "then": true}', "1000 steps"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_a_sentence(browser: Any, tools: Tools, text: str, why: str) -> None:
    _, hear = tools
    session = browser.session
    before = session.state()
    with browser.opened() as socket:
        for frame in (text, text.encode()):
            socket.send(frame)
            said = hear(socket)
            assert said["say"] == "refusal"
            assert why in said["why"]
    assert session.state() == before


# --- two tabs ------------------------------------------------------------------------------------


def test_a_second_tab_reads_along_and_a_third_is_refused(browser: Any, tools: Tools) -> None:
    ask, hear = tools
    with browser.opened() as first, browser.socket() as second:
        assert hear(second)["role"] == "reads along"
        assert ask(second, "pause")["why"] == "this page reads along; another one gives the orders"
        assert ask(second, "look", piece="tank0", at=None)["say"] == "answer"
        with browser.socket() as third:
            assert hear(third)["why"].startswith("two pages are open already")
            assert closed_with(third) == 1013
        ask(first, "step", to="tick")
        assert [hear(second)["clock"]["tick"] for _ in range(2)] == [0, 1]


def test_without_the_tab_that_commands_the_clock_stops_and_the_other_takes_over(
    begin: Begin, served: Serve, tools: Tools
) -> None:
    ask, hear = tools
    browser = served(begin(), pace=1.0)
    browser.enter()
    with ExitStack() as ends:
        first = ends.enter_context(browser.opened())
        with browser.socket() as second:
            assert hear(second)["role"] == "reads along"
            ask(first, "run", speed=1)
            ends.close()
            while (message := hear(second))["say"] != "hello":
                pass
            assert message["role"] == "commands"
            assert message["clock"]["running"] is False
            assert ask(second, "step", to="tick")["say"] == "answer"


def test_a_closed_tab_loses_nothing(browser: Any, tools: Tools) -> None:
    ask, hear = tools
    with browser.opened() as socket:
        ask(socket, "plan", piece="tank0", steps=["tank0 go 1234", "tank0 hide"], then=False)
        ask(socket, "step", to="tick")
        while hear(socket)["clock"]["tick"] < 1:
            pass
    with browser.socket() as socket:
        while (hello := hear(socket))[
            "role"
        ] != "commands":  # until the server knows that the other one is gone
            pass
    assert hello["clock"]["tick"] == 1
    assert hello["plans"] == {"tank0": ["tank0 go 1234", "tank0 hide"]}


def test_the_game_is_kept_when_the_server_stops(browser: Any, tools: Tools) -> None:
    ask, _ = tools
    with browser.opened() as socket:
        ask(socket, "step", to="tick")
        browser.server.stop()
        assert closed_with(socket) == 1012
    assert browser.session.record.path.exists()


# --- the clock -----------------------------------------------------------------------------------


class Ear:
    """A socket that notes what it is told, and when."""

    def __init__(self) -> None:
        self.heard: list[tuple[float, Any]] = []

    async def send_text(self, data: str) -> None:
        self.heard.append((asyncio.get_running_loop().time(), json.loads(data)))

    async def close(self, code: int) -> None:
        raise AssertionError(code)


def test_messages_come_at_a_fixed_pace_however_long_ticks_take(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, slow = begin(), [0]
    advance = session.advance

    def uneven() -> Any:
        slow[0] += 1
        time.sleep(0.02 * (slow[0] % 2))
        return advance()

    monkeypatch.setattr(session, "advance", uneven)

    async def listen() -> list[float]:
        room, ear = Room(session), Ear()
        clock = asyncio.create_task(room.keep_time())
        visitor = await room.welcome(ear)
        assert visitor is not None
        await room.take(visitor, '{"id": 1, "ask": "run", "speed": 64}')
        await asyncio.sleep(1.5)
        clock.cancel()
        return [at for at, message in ear.heard if message["say"] == "now"][1:]

    times = asyncio.run(listen())
    gaps = [later - earlier for earlier, later in pairwise(times)]

    assert sum(gaps) / len(gaps) == pytest.approx(0.125, abs=0.02)
    assert room_module.SLACK_SECONDS < 0.125


def test_a_disk_that_is_full_stops_the_clock_and_says_so(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = begin()
    monkeypatch.setattr(
        session, "advance", lambda: (_ for _ in ()).throw(OSError(28, "No space left on device"))
    )

    async def listen() -> list[Any]:
        room, ear = Room(session, pace=0.0), Ear()
        clock = asyncio.create_task(room.keep_time())
        visitor = await room.welcome(ear)
        assert visitor is not None
        await room.take(visitor, '{"id": 1, "ask": "run", "speed": 8}')
        await asyncio.sleep(0.2)
        assert not clock.done()
        clock.cancel()
        return [message for _, message in ear.heard]

    assert asyncio.run(listen())[-1] == {
        "say": "refusal",
        "to": None,
        "why": "[Errno 28] No space left on device",
    }
    assert not session.clock.running


def test_a_socket_that_takes_nothing_does_not_hold_up_the_game(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room_module, "SEND_SECONDS", 0.05)

    class Deaf(Ear):
        async def send_text(self, data: str) -> None:
            await asyncio.sleep(60)

    async def listen() -> int:
        room, ear = Room(begin(), pace=0.0), Ear()
        clock = asyncio.create_task(room.keep_time())
        visitor, deaf = await room.welcome(ear), await room.welcome(Deaf())
        assert visitor is not None
        assert deaf is not None
        await room.take(visitor, '{"id": 1, "ask": "step", "to": "decision"}')
        await asyncio.sleep(1.0)
        clock.cancel()
        assert deaf.gone
        return int(ear.heard[-1][1]["clock"]["tick"])

    assert asyncio.run(listen()) == 75


def test_a_change_of_speed_does_not_wait_for_the_next_tick(begin: Begin) -> None:
    async def listen() -> int:
        room, ear = Room(begin()), Ear()
        clock = asyncio.create_task(room.keep_time())
        visitor = await room.welcome(ear)
        assert visitor is not None
        await room.take(visitor, '{"id": 1, "ask": "run", "speed": 1}')
        await room.take(visitor, '{"id": 2, "ask": "run", "speed": 64}')
        await asyncio.sleep(0.7)
        clock.cancel()
        return int(ear.heard[-1][1]["clock"]["tick"])

    assert asyncio.run(listen()) >= 8


def test_a_socket_of_ours_is_what_connects(browser: Any) -> None:
    """Another path is none, with the cookie or without."""
    address, cookie = f"ws://{browser.host}/other", {"Cookie": browser.cookie}
    with (
        pytest.raises(InvalidStatus, match="403"),
        connect(address, origin=browser.origin, additional_headers=cookie),
    ):
        pass
