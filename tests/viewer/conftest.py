"""Recorded games, and a reader of stories that is as plain as the page on the format."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.play import record_game

Json = dict[str, Any]


def value_at(changes: list[Any] | None, tick: int, usual: Any) -> Any:
    """The value that holds at a tick."""
    found = usual
    for at, value in zip((changes or [])[::2], (changes or [])[1::2], strict=True):
        if at > tick:
            break
        found = value
    return found


def cell_at(own: Json, tick: int) -> int:
    """Where a piece stands: its last hop that was not broken off, or a jump since then."""
    jumps = list(zip(own.get("cell", [])[::2], own.get("cell", [])[1::2], strict=True))
    hops = [(hop[1], hop[2]) for hop in own["hops"] if len(hop) == 3]
    done = [place for place in sorted([*hops, *jumps], key=lambda place: place[0]) if place[0] <= tick]
    return int(done[-1][1])


@pytest.fixture
def at() -> Callable[..., Any]:
    return value_at


@pytest.fixture
def where() -> Callable[[Json, int], int]:
    return cell_at


@pytest.fixture(scope="session")
def replay() -> Replay:
    """A game of two scripted players, with shots, deaths, captures and rides."""
    return record_game("MA1", "MA2", seed=3)
