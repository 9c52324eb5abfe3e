"""The events of a game as a table (formats/events.md): one row an event, with what it takes to put many games together."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.known_events import DICE
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ReplayFileError, UnknownNameError
from hexwar_sb3.files import replacing
from hexwar_sb3.kernels import Rows
from hexwar_sb3.viewer.luck import judge_shots
from hexwar_sb3.viewer.scene import names_of
from hexwar_sb3.viewer.story import NAME_CHARACTERS, REFEREE, VIEWS

Row = dict[str, Any]
COLUMNS = (
    *("tick", "camp", "piece", "kind", "cell", "target", "shooter", "weapon", "level", "cells_apart"),
    *("roll", "raw", "correction_roll", "modifiers", "correction"),
    *("result", "losses", "hit", "expected", "variance", "lost"),
    *("scenario", "rules", "red", "blue", "seed"),
)
SECRET = frozenset({*DICE, "expected", "variance", "lost", "seed"})
"""Columns that a camp's table does not have."""
_FORMULA = ("=", "+", "-", "@", "\t", "\r")  # a text that begins so is run by spreadsheets


def save_events(replay: Replay, path: str | Path, view: str = REFEREE) -> None:
    """Write the events of a game as CSV, whole or not at all.

    Args:
        replay: a whole one, or the camp's own record.
        path: of the file.
        view: "referee", or a camp: then the events that it could see, without dice and luck.

    Raises:
        UnknownNameError: another view.
        ReplayFileError: it is the record of another camp.

    Example:
        >>> game = Game("plain", seed=0)
        >>> events = game.advance(75)
        >>> save_events(Replay.of(game), "events.csv", "red")
    """
    rows = event_rows(replay, view)
    with replacing(Path(path)) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns_of(view), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def columns_of(view: str) -> list[str]:
    """The columns of a view's table."""
    return [name for name in COLUMNS if view == REFEREE or name not in SECRET]


def event_rows(replay: Replay, view: str = REFEREE) -> list[Row]:
    """The rows of the table; what an event does not have is left out."""
    if view not in VIEWS:
        raise UnknownNameError("view", view, VIEWS)
    same = _of_all(replay, view)
    events = _judged(replay) if view == REFEREE else _known(replay, view)
    names = columns_of(view)
    rows = ({"camp": event["piece"].split(":")[0], **event, **same} for event in events)
    return [{name: row[name] for name in names if name in row} for row in rows]


def _of_all(replay: Replay, view: str) -> Row:
    """What stands in every row."""
    head = replay.head
    said = {"scenario": head["scenario"]["name"][:NAME_CHARACTERS], **names_of(replay)}
    texts = {name: f"'{text}" if text.startswith(_FORMULA) else text for name, text in said.items()}
    seed = {"seed": replay.seed} if view == REFEREE else {}
    return {**texts, "rules": head["rules"]["version"], **seed}


def _known(replay: Replay, camp: str) -> list[Row]:
    if replay.camp is None:
        return replay.for_camp(camp).events
    if replay.camp != camp:
        found = f"the record of {replay.camp}"
        raise ReplayFileError(replay.source, "head", found=found, expected=f"a whole replay, or {camp}'s")
    return replay.events


def _judged(replay: Replay) -> Iterator[Row]:
    """All events, and each shot with its luck: the game is played again."""
    before: Rows | None = None
    for game, events in replay.ticks():
        luck = {} if before is None else judge_shots(events, before, game.world, game.roster)
        for number, event in enumerate(events):
            if event.kind != "refused":  # the orders have it
                yield event.as_dict() | (luck[number].told() if number in luck else {})
        before = game.pieces.copy()
