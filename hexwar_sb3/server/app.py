"""The server of `hexwar play`: addresses, limits, and who may pass (formats/play.md, SECURITY.md)."""

from __future__ import annotations

import asyncio
import re
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from hexwar_sb3.engine.replay_file import packed_lines
from hexwar_sb3.server.guard import HOSTS, SOCKET, Guard
from hexwar_sb3.server.messages import MOST_BYTES
from hexwar_sb3.server.pages import headers_of, plain_headers, play_page, rules_page
from hexwar_sb3.server.room import FLOOD, Room
from hexwar_sb3.server.session import Session
from hexwar_sb3.viewer.page import replay_page

MOST_BODY = 65_536  # bytes
BODY_SECONDS = 10.0  # for all of it
CONNECTION_SECONDS = (
    30.0  # from a connection's beginning to its end, unless an answer or a socket is under way
)
MOST_CONNECTIONS = 64
PING_SECONDS = 20.0  # a socket that does not answer for so long is gone


class Gate:
    """Lets requests pass that the guard knows; all others get 403 or 413, and nothing else."""

    def __init__(self, app: ASGIApp, guard: Guard) -> None:
        self.app, self.guard = app, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Look at a request before anything else does."""
        if scope["type"] == "http":
            refusal = self._refusal(scope)
            if refusal is not None:
                await refusal(scope, receive, send)
                return
        elif scope["type"] == "websocket" and not self.guard.may_connect(scope["path"], scope["headers"]):
            await WebSocket(scope, receive, send).close()  # before it is accepted: 403
            return
        await self.app(scope, receive, send)

    def _refusal(self, scope: Scope) -> Response | None:
        if not self.guard.may_pass(scope["method"], scope["path"], scope["headers"]):
            return refused(403)
        if _length(scope) > MOST_BODY:
            return refused(413)
        return None


def _length(scope: Scope) -> int:
    """Length of the body, as the request says it."""
    values = [value for name, value in scope["headers"] if name == b"content-length"]
    return int(values[0]) if values and values[0].isdigit() else 0


def refused(status: int) -> Response:
    """An answer that says no, and closes the connection: the rest of a long body is not read."""
    return Response(status_code=status, headers={**plain_headers(), "connection": "close"})


class Server:
    """One game behind one port of this machine.

    Args:
        session: the game.
        port: to listen on; 0: any that is free.
        pace: seconds that a second of the clock takes.

    Raises:
        OSError: the port cannot be had.
    """

    def __init__(self, session: Session, port: int = 0, pace: float = 1.0) -> None:
        self.session, self.pace = session, pace
        self.listener = socket.create_server((HOSTS[0], port))
        self.guard = Guard(self.listener.getsockname()[1])
        self._after: str | None = None
        self.uvicorn = uvicorn.Server(self._config())

    def run(self) -> None:
        """Serve until it is stopped."""
        self.uvicorn.run(sockets=[self.listener])

    def stop(self) -> None:
        """Stop serving; from another thread."""
        self.uvicorn.should_exit = True

    def _config(self) -> uvicorn.Config:
        return uvicorn.Config(
            self._app(),
            http=BriefConnection,
            ws="websockets-sansio",
            ws_max_size=MOST_BYTES,
            ws_per_message_deflate=False,
            ws_ping_interval=PING_SECONDS,
            ws_ping_timeout=PING_SECONDS,
            limit_concurrency=MOST_CONNECTIONS,
            timeout_graceful_shutdown=1,
            log_config=None,
            log_level="critical",
            access_log=False,
            server_header=False,
            proxy_headers=False,
        )

    def _app(self) -> Starlette:
        routes = [
            Route("/", self._play),
            Route("/enter", self._enter, methods=["POST"]),
            Route("/rules", self._rules),
            Route("/after", self._whole),
            Route("/replay", self._replay),
            WebSocketRoute(SOCKET, self._socket),
        ]
        return Starlette(routes=routes, middleware=[Middleware(Gate, self.guard)], lifespan=self._lifespan)

    @asynccontextmanager
    async def _lifespan(self, _: Starlette) -> AsyncIterator[None]:
        self.room = Room(self.session, self.pace)
        clock = asyncio.create_task(self.room.keep_time())
        yield
        await self.room.close()
        clock.cancel()
        with suppress(asyncio.CancelledError):
            await clock

    # --- addresses -------------------------------------------------------------------------------

    async def _play(self, _: Request) -> Response:
        page = play_page()
        return HTMLResponse(page, headers=headers_of(page, connects=True))

    async def _rules(self, _: Request) -> Response:
        page = rules_page()
        return HTMLResponse(page, headers=headers_of(page))

    async def _enter(self, request: Request) -> Response:
        body = await _body(request)
        if body is None:
            return refused(413)
        if not self.guard.enter(body.strip(), request.scope["headers"]):
            return refused(403)
        return Response(status_code=204, headers={**plain_headers(), "set-cookie": self.guard.cookie})

    async def _whole(self, _: Request) -> Response:
        replay = self.session.replay
        if replay is None:
            return refused(403)
        if self._after is None:
            self._after = await asyncio.to_thread(replay_page, replay)
        return HTMLResponse(self._after, headers=headers_of(self._after))

    async def _replay(self, _: Request) -> Response:
        replay = self.session.replay
        if replay is None:
            return refused(403)
        name = re.sub(r"[^\w.-]", "_", self.session.file.name, flags=re.ASCII)
        headers = plain_headers() | {"content-disposition": f'attachment; filename="{name}"'}
        return Response(packed_lines(replay.lines), media_type="application/octet-stream", headers=headers)

    async def _socket(self, websocket: WebSocket) -> None:
        await websocket.accept()
        visitor = await self.room.welcome(websocket)
        if visitor is None:
            return
        try:
            while True:
                text = await _message(websocket)
                if visitor.floods():
                    await websocket.close(FLOOD)
                    return
                await self.room.take(visitor, text)
        except WebSocketDisconnect:
            pass
        finally:
            await self.room.leave(visitor)


async def _message(websocket: WebSocket) -> str | bytes:
    found = await websocket.receive()
    if found["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(found.get("code") or 1000)
    text: str | bytes = found["bytes"] if found.get("text") is None else found["text"]
    return text


async def _body(request: Request) -> bytes | None:
    """The body; None if it is too long, or does not come."""
    data = bytearray()
    try:
        async with asyncio.timeout(BODY_SECONDS):
            async for part in request.stream():
                data += part
                if len(data) > MOST_BODY:
                    return None
    except (TimeoutError, ClientDisconnect):
        return None
    return bytes(data)


class BriefConnection(H11Protocol):
    """A connection that is closed after a while, whatever it waits for, unless an answer or a socket is under way."""

    def connection_made(self, transport: Any) -> None:
        """Begin to count; a message is sent at once, also where the one before it was not acknowledged yet."""
        super().connection_made(transport)
        transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._end: Callable[[], Any] = self._wait().cancel

    def connection_lost(self, exc: Exception | None) -> None:
        """It ended by itself."""
        self._end()
        super().connection_lost(exc)

    def _wait(self) -> asyncio.TimerHandle:
        return self.loop.call_later(CONNECTION_SECONDS, self._look)

    def _look(self) -> None:
        if self.transport.get_protocol() is not self:
            return  # a socket took over
        answer: Any = self.cycle  # none before the first request
        if answer is not None and not answer.response_complete:
            self._end = self._wait().cancel
        else:
            self.transport.close()
