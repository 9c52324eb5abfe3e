"""Who is at the table: up to two sockets, one game, and the clock that plays it."""

from __future__ import annotations

import asyncio
import json
import time
from collections import deque
from contextlib import suppress
from typing import Any, Protocol

from hexwar_sb3.errors import HexWarError
from hexwar_sb3.server.messages import (
    Finish,
    Pause,
    Question,
    Run,
    StepTo,
    number_of,
    read_message,
    read_question,
)
from hexwar_sb3.server.session import COMMANDS, READS, Session

SEATS = 2
MOST_MESSAGES, IN_SECONDS = 50, 1.0  # of a socket
SEND_SECONDS = 5.0  # a socket that takes no message for so long is gone
SLACK_SECONDS = (
    0.05  # in which ticks are worked out: a message comes when they are over, however long it took
)
MOST_SAID = 1_000  # characters of a refusal, which may repeat what was asked
FLOOD, BUSY = 1008, 1013  # reasons to close a socket
Json = dict[str, Any]


Failure = (HexWarError, OSError)  # OSError: what is to be kept cannot be written


def _refusal(number: int | None, error: Exception) -> Json:
    return {"say": "refusal", "to": number, "why": str(error)[:MOST_SAID]}


class Socket(Protocol):
    """What a room needs of a WebSocket."""

    async def send_text(self, data: str) -> None:
        """Send a message."""

    async def close(self, code: int) -> None:
        """Close it."""


class Visitor:
    """One socket: whether it commands, and how much it asks."""

    gone = False  # it takes no more messages; what is left of it ends by its pings

    def __init__(self, socket: Socket, role: str) -> None:
        self.socket, self.role = socket, role
        self._asked: deque[float] = deque(maxlen=MOST_MESSAGES)

    async def say(self, message: Json) -> None:
        """Send a message; one that cannot be sent is the last."""
        if self.gone:
            return
        text = json.dumps(message, separators=(",", ":"), ensure_ascii=False)
        try:
            await asyncio.wait_for(self.socket.send_text(text), SEND_SECONDS)
        except Exception:  # noqa: BLE001  # whatever a closed socket raises, its reader ends, too
            self.gone = True

    def floods(self) -> bool:
        """Count a message; whether there were too many in the last second."""
        now = time.monotonic()
        full = len(self._asked) == MOST_MESSAGES and now - self._asked[0] < IN_SECONDS
        self._asked.append(now)
        return full


class Room:
    """Takes questions one after the other, and lets the clock run in between.

    Args:
        session: the game.
        pace: seconds that a second of the clock takes; 0 in tests.
    """

    def __init__(self, session: Session, pace: float = 1.0) -> None:
        self.session, self.pace = session, pace
        self.visitors: list[Visitor] = []
        self._lock = asyncio.Lock()
        self._changed = asyncio.Event()

    # --- who comes and goes ----------------------------------------------------------------------

    async def welcome(self, socket: Socket) -> Visitor | None:
        """A new socket; None if there is no seat left."""
        async with self._lock:
            if len(self.visitors) == SEATS:
                why = "two pages are open already: one commands, one reads along"
                await Visitor(socket, READS).say({"say": "refusal", "to": None, "why": why})
                await socket.close(BUSY)
                return None
            visitor = Visitor(socket, READS if self.visitors else COMMANDS)
            self.visitors.append(visitor)
            await visitor.say(self.session.hello(visitor.role))
        return visitor

    async def leave(self, visitor: Visitor) -> None:
        """A socket is gone: without the one that commands the clock stops, and the other one takes over."""
        async with self._lock:
            self.visitors.remove(visitor)
            if visitor.role == COMMANDS:
                self.session.clock.stop()
                self._changed.set()
                for other in self.visitors:
                    other.role = COMMANDS
                    await other.say(self.session.hello(COMMANDS))

    async def close(self) -> None:
        """Stop the clock, and wait for the tick that is under way."""
        self.session.clock.stop()
        async with self._lock:
            self.session.close()

    # --- questions -------------------------------------------------------------------------------

    async def take(self, visitor: Visitor, text: str | bytes) -> None:
        """A message of a socket."""
        number = None
        try:
            message = read_message(text)
            number = number_of(message)
            question = read_question(message)
            async with self._lock:
                await self._answer(visitor, number, question)
        except Failure as error:
            await visitor.say(_refusal(number, error))

    async def _answer(self, visitor: Visitor, number: int | None, question: Question) -> None:
        fields, changed = await asyncio.to_thread(self.session.answer, question, visitor.role)
        await visitor.say({"say": "answer", "to": number, **fields})
        if changed:
            await self._tell_all(self.session.now())
        if isinstance(question, Run | Pause | StepTo | Finish):
            self._changed.set()

    async def _tell_all(self, message: Json) -> None:
        for visitor in list(self.visitors):
            await visitor.say(message)

    # --- the clock -------------------------------------------------------------------------------

    async def keep_time(self) -> None:
        """Let the clock run whenever it is to run; for ever."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            await self._run()

    async def _run(self) -> None:
        """Play until the clock stops, or until it is to run in another way."""
        loop, clock = asyncio.get_running_loop(), self.session.clock
        due = loop.time()
        while clock.running and not self._changed.is_set():
            seconds = clock.seconds * self.pace
            due = max(due + seconds, loop.time())
            if await self._is_changed_before(due):
                return
            async with self._lock:
                if clock.running:
                    await self._play(due + min(seconds, SLACK_SECONDS * self.pace))

    async def _is_changed_before(self, due: float) -> bool:
        left = due - asyncio.get_running_loop().time()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._changed.wait(), max(left, 0.0))
        return self._changed.is_set()

    async def _play(self, told_at: float) -> None:
        """Play the next ticks; they are told at a time that does not tell how long they took."""
        try:
            now = await asyncio.to_thread(self.session.advance)
        except Failure as error:  # nothing is told of ticks that are not kept
            self.session.clock.stop()
            await self._tell_all(_refusal(None, error))
            return
        await asyncio.sleep(max(0.0, told_at - asyncio.get_running_loop().time()))
        await self._tell_all(now)
        if self.session.replay is not None:
            await self._tell_all(self.session.over())
