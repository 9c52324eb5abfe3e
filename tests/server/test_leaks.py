"""Information: games that differ only in what red cannot see say the same to red, byte for byte, message for message."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.server import imagine
from hexwar_sb3.server.room import Room
from hexwar_sb3.server.session import Session, Setup
from hexwar_sb3.server.stops import Stops
from hexwar_sb3.viewer import camp_story

Json = dict[str, Any]
FAR = """
    map   plain-60x9
    point ford 3005 40
    red   tank 0204
    red   chariot 0205
    red   aerocraft 0305
    blue  tank 5604
    blue  soldier 5505
    blue  aerocraft 5903
    ticks 1200
"""
NEAR = FAR.replace("blue  tank 5604", "blue  tank 1204")
SCRIPT: list[Json] = [
    {
        "ask": "plan",
        "piece": "tank0",
        "steps": ["tank0 go 0404", "tank0 hide", "tank0 occupy"],
        "then": False,
    },
    {
        "ask": "plan",
        "piece": "aerocraft0",
        "steps": ["aerocraft0 go 2005", "aerocraft0 go 1005"],
        "then": False,
    },
    {"ask": "look", "piece": "chariot0", "at": None},
    {"ask": "look", "piece": "tank0", "at": 250},
    {"ask": "path", "piece": "tank0", "to": 250, "from": None},
    {"ask": "plan", "piece": "chariot0", "steps": ["chariot0 indirect-shoot 1505"], "then": False},
    {"ask": "undo"},
    {"ask": "step", "to": "tick"},
    {"ask": "step", "to": "event"},
    {"ask": "look", "piece": "tank0", "at": 240},
    {"ask": "step", "to": "decision"},
    {"ask": "path", "piece": "aerocraft0", "to": 290, "from": 245},
    {"ask": "plan", "piece": "chariot0", "steps": ["chariot0 go 0306"], "then": False},
    {"ask": "run", "speed": 64},
    {"ask": "plan", "piece": "tank0", "steps": ["blue:tank0 hide"], "then": False},
    {"ask": "step", "to": "decision"},
]
MORTAR: list[Json] = [  # where it comes down dice say, so not with another seed
    {"ask": "plan", "piece": "chariot0", "steps": ["chariot0 indirect-shoot 1204"], "then": False},
    *[{"ask": "step", "to": "decision"}] * 2,
]
DECISIONS = 2  # in which blue does something; it stays far away


class Hidden:
    """Blue: it stays where it is (seed 0), or all but its tank, which stays if it is to, does something or other."""

    decided = 0

    def __init__(self, seed: int, stays: bool) -> None:
        self.rng, self.stays, self.still = np.random.default_rng(seed), stays, seed == 0

    def act(self, obs: Json) -> Any:
        """One of the tasks that each piece may have."""
        masks = obs["action_mask"][0]
        self.decided += 1
        self.still = self.still or self.decided > DECISIONS
        tasks = [self.rng.choice(np.flatnonzero(mask)) if mask.any() else 0 for mask in masks]
        return np.array(
            [[0 if self.still or (self.stays and n == 0) else task for n, task in enumerate(tasks)]]
        )


class Ear:
    """A socket that keeps what it is told, as it is told."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    async def send_text(self, data: str) -> None:
        self.heard.append(data)

    async def close(self, code: int) -> None:
        raise AssertionError(code)


def session_of(board: str, seed: int, blue: int) -> Session:
    opponent: Any = Hidden(blue, stays=board is NEAR)
    return Session(Setup(scenario=scenario_of(board), seed=seed, opponent=opponent))


def scenario_of(board: str) -> Scenario:
    return parse_board(board).scenario


def transcript(session: Session, *first: Json) -> list[str]:
    """What a scripted red is told by the room of a game; the clock takes no time."""

    async def listen() -> list[str]:
        room, ear = Room(session, pace=0.0), Ear()
        clock = asyncio.create_task(room.keep_time())
        visitor = await room.welcome(ear)
        assert visitor is not None
        for number, question in enumerate((*first, *SCRIPT)):
            await room.take(visitor, json.dumps({"id": number} | question))
            while '"running":true' in ear.heard[-1]:  # noqa: ASYNC110  # as a browser waits
                await asyncio.sleep(0.001)
        clock.cancel()
        return ear.heard

    heard = asyncio.run(listen())
    assert not session.game.over
    return heard


def orders_of_blue(session: Session) -> list[Json]:
    lines = session.game.recorder.lines
    return [line for line in lines if line["type"] == "orders" and line["camp"] == "blue"]


@pytest.mark.parametrize(("seed", "blue"), [(2, 7), (2**62 + 1, 8), (5, 9)])
def test_red_is_told_the_same_whatever_it_cannot_see(seed: int, blue: int) -> None:
    """Another seed of the dice, other plans of blue's, all out of sight."""
    first, other = session_of(FAR, 1, 1), session_of(FAR, seed, blue)

    assert transcript(first) == transcript(other)
    assert orders_of_blue(first) != orders_of_blue(other)


@pytest.mark.parametrize("blue", [7, 8])
def test_red_is_told_the_same_of_a_fight_whatever_else_happens(blue: int) -> None:
    first, other = session_of(NEAR, 1, 1), session_of(NEAR, 1, blue)

    told = transcript(first, *MORTAR)

    assert told == transcript(other, *MORTAR)
    assert orders_of_blue(first) != orders_of_blue(other)
    assert {"shot", "mortar_landed"} <= set(re.findall(r'"kind":"(\w+)"', "".join(told)))


def test_red_is_told_what_it_sees() -> None:
    """Else their being equal would say little."""
    first, other = session_of(NEAR, 1, 1), session_of(NEAR, 1, 1)
    other.game.pieces[3].blood = 1

    assert transcript(first) != transcript(other)


def state_with_the_margin(session: Session, state: Json) -> Json:
    return state | {"margin": session.game.margin("red")}


def state_with_the_seed(session: Session, state: Json) -> Json:
    return state | {"seed": session.game.seed}


def state_with_a_hidden_length(session: Session, state: Json) -> Json:
    return state | {"x": [0] * sum(line["type"] == "event" for line in session.game.recorder.lines)}


@pytest.mark.parametrize("leak", [state_with_the_margin, state_with_the_seed, state_with_a_hidden_length])
def test_a_planted_leak_is_found(leak: Callable[..., Json], monkeypatch: pytest.MonkeyPatch) -> None:
    state = Session.state
    monkeypatch.setattr(Session, "state", lambda self: leak(self, state(self)))
    first, other = session_of(FAR, 1, 0), session_of(FAR, 2, 7)
    other.game.pieces[4].blood = 1

    assert transcript(first) != transcript(other)


def test_an_event_of_an_unseen_piece_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camp_story, "is_known", lambda *_: True)
    monkeypatch.setattr(camp_story, "DULL", frozenset())

    assert transcript(session_of(FAR, 1, 0)) != transcript(session_of(FAR, 1, 7))


def test_one_message_more_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock stops, or a batch ends, where something happens that red does not see."""
    tick = Session._tick

    def stopping(self: Session) -> Any:
        n_events = len(self.game.recorder.lines)
        found = tick(self)
        if any(line.get("piece", "").startswith("blue") for line in self.game.recorder.lines[n_events:]):
            self.clock.stop()
        return found

    monkeypatch.setattr(Session, "_tick", stopping)

    assert transcript(session_of(FAR, 1, 0)) != transcript(session_of(FAR, 1, 7))


# --- answers, with all that is unseen turned over ------------------------------------------------

QUESTIONS: list[Json] = [
    *(
        {"ask": "look", "piece": piece, "at": at}
        for piece in ("tank0", "chariot0", "soldier0")
        for at in (None, 2500, 2430)
    ),
    *(
        {"ask": "path", "piece": piece, "to": to, "from": None}
        for piece in ("tank0", "aerocraft0")
        for to in (2500, 1800)
    ),
    {"ask": "hint", "piece": "tank1"},
    {"ask": "plan", "piece": "tank0", "steps": ["tank0 shoot blue:tank0 GUN"], "then": False},
    {"ask": "plan", "piece": "tank1", "steps": ["tank1 go 2528", "tank1 occupy"], "then": False},
]


def met() -> Session:
    """A game in which red saw some of blue's pieces, and sees some now."""
    session = Session(Setup(seed=4, opponent="MA1", hints="HRL0"))
    session.seat.plan("aerocraft0", ("aerocraft0 go 4138", "aerocraft0 go 1030"))
    session.seat.plan("tank0", ("tank0 go 2832",))
    session.stops = Stops(False, False, False)
    session.clock.run(64)
    while not session.game.view("red").lost:
        session.advance()
    session.clock.stop()
    assert session.game.tick < 1500
    return session


def answers(session: Session) -> list[str]:
    async def listen() -> list[str]:
        room, ear = Room(session, pace=0.0), Ear()
        visitor = await room.welcome(ear)
        assert visitor is not None
        for number, question in enumerate(QUESTIONS):
            await room.take(visitor, json.dumps({"id": number} | question))
        return ear.heard

    return asyncio.run(listen())


@pytest.mark.parametrize("seed", [0, 1])
def test_answers_are_the_same_whatever_is_unseen(scramble: Callable[..., None], seed: int) -> None:
    first, other = met(), met()
    scramble(other.game._arena, 0, Camp.RED, np.random.default_rng(seed))

    told = answers(first)

    assert told == answers(other)
    assert sum('"refusal"' in message for message in told) < 3


def test_an_answer_by_the_truth_would_be_found(
    scramble: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(imagine, "known_pieces", lambda _, pieces, __: pieces.copy())
    first, other = met(), met()
    scramble(other.game._arena, 0, Camp.RED, np.random.default_rng(0))

    assert answers(first) != answers(other)
