"""Questions are checked before anything uses them, and what is wrong is said with its place."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.server.messages import (
    MOST_BYTES,
    QUESTIONS,
    VERSION,
    Run,
    StepTo,
    number_of,
    read_message,
    read_question,
)

PAGE = (Path(__file__).parents[2] / "docs/formats/play.md").read_text(encoding="utf-8")
Bad = Callable[[Any], Iterator[bytes]]


def example(name: str) -> Any:
    """The block right after the mark of that name."""
    return json.loads(PAGE.partition(f"<!-- example: play.{name} -->\n```json\n")[2].partition("\n```")[0])


def test_every_question_of_the_page_on_the_protocol_is_one() -> None:
    asked = [read_question(message) for message in example("asks")]

    assert sorted(map(str, map(type, asked))) == sorted(map(str, QUESTIONS.values()))
    assert f"protocol, version {VERSION}" in PAGE
    assert f"{MOST_BYTES:,} bytes" in PAGE


@pytest.mark.parametrize(
    ("message", "why"),
    [
        ({}, "message: id: found null; expected a whole number"),
        ({"id": 1}, "message: ask: found null; expected one of look, path"),
        ({"id": 1, "ask": "fly"}, 'message: ask: found "fly"'),
        ({"id": True, "ask": "undo"}, "message: id: found true"),
        ({"id": 1, "ask": "run", "speed": 65}, "message: speed: found 65; expected 1..64"),
        ({"id": 1, "ask": "run", "speed": 0}, "message: speed: found 0"),
        ({"id": 1, "ask": "run"}, "message: run.speed: found nothing; expected a whole number"),
        ({"id": 1, "ask": "run", "speed": 1.0}, "message: run.speed: found 1.0"),
        ({"id": 1, "ask": "undo", "also": 1}, "message: undo.also: found an unknown setting"),
        ({"id": 1, "ask": "step", "to": "end"}, "message: step.to: found 'end'"),
        ({"id": 1, "ask": "plan", "piece": "a", "steps": [1], "then": False}, "message: plan.steps"),
        ({"id": 1, "ask": "look", "piece": ["tank0"], "at": None}, "message: look.piece"),
    ],
)
def test_what_is_wrong_is_said(message: dict[str, Any], why: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        read_question(message)

    assert str(caught.value).startswith(why)


@pytest.mark.parametrize(
    "text", ["", "[]", "1", "{", '{"id": NaN}', '{"a": 1, "a": 2}', "[" * 1000, b"\xff\xfe"]
)
def test_what_is_no_object_is_no_message(text: str | bytes) -> None:
    with pytest.raises(FileFormatError):
        read_message(text)


def test_hundreds_of_broken_messages_are_refused_or_read(bad: Bad) -> None:
    texts = [text for question in example("asks") for text in bad(question)]
    said = [why_not(text) for text in texts]

    assert all(len(why) < 1_000 for why in said)
    assert sum(map(bool, said)) > len(texts) / 2


def why_not(text: bytes) -> str:
    """Why a message is refused; nothing where it is read."""
    try:
        read_question(read_message(text))
    except FileFormatError as error:
        return str(error)
    return ""


def test_the_number_of_a_message_is_whole_or_none() -> None:
    assert [number_of({"id": one}) for one in (3, -3, True, "3", 2**53, None, 1.0)] == [3, -3, *[None] * 5]


def test_questions_are_values() -> None:
    assert read_question({"id": 1, "ask": "run", "speed": 8}) == Run(8)
    assert read_question({"id": 1, "ask": "step", "to": "event"}) == StepTo("event")
