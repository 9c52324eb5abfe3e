"""Recorded games, and a reader of stories that is as plain as the page on the format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.play import record_game
from hexwar_sb3.viewer.album import Album, Clip

Json = dict[str, Any]
PARTED_AT = 150  # tick


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


def parted(replay: Replay) -> Replay:
    """The same game until a tick, from which on nobody gives orders."""
    game = replay.game_at(PARTED_AT)
    game.advance(300)
    return Replay.of(game)


@pytest.fixture(scope="session")
def pages(replay: Replay, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages of two games that part: an album, both side by side, a league with its lineage."""
    folder = tmp_path_factory.mktemp("pages")
    for name, game in (("a", replay), ("b", parted(replay))):
        game.save(folder / f"{name}.hwr")
    clips = [Clip(path=folder / f"{name}.hwr", name=name) for name in ("a", "b")]
    rate = [0.5, 0.4, 0.6]
    curve = {"games": 9, "rows": [[0, 1, rate, [-3.0, -4.0, -2.0]], [500, 2, rate, [5.0, 4.0, 6.0]]]}
    told = {"rate": rate, "games": 9, "episode": 4, "seed": 0}
    names = ["commander_1", "drawn-unseen", "MA1", "two-hold", "half-half"]
    cells = [[{**told, "game": 2}, {**told, "game": 1}, None, told, told], [told] * len(names)]
    table = {"name": "plain", "red": names[:2], "blue": names, "cells": cells}
    kept = [[{"name": name, "parent": names[0], "rate": 0.6} for name in names[:2]] for _ in range(3)]
    covers: Json = {
        "album": {"kind": "album", "curve": curve},
        "compare": {"kind": "compare"},
        "league": {
            "kind": "league",
            "tables": [table, {**table, "name": "hills"}],
            "lineage": {"both": kept},
        },
    }
    for kind, cover in covers.items():
        Album(title=kind, clips=clips, cover=cover).save(folder / f"{kind}.html")
    return {kind: folder / f"{kind}.html" for kind in covers}
