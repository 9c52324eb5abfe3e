"""Whether a snapshot of the task env, which may come from a file, fits the env that is to go on with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.fields import check_all, check_form, check_names, check_range, refuse
from hexwar_sb3.engine.state import State
from hexwar_sb3.errors import CheckpointError, ConfigError, shortened
from hexwar_sb3.kernels import Rows
from hexwar_sb3.play.arena import Arena, Snapshot
from hexwar_sb3.play.lower import KEPT
from hexwar_sb3.play.records import EXTERNAL
from hexwar_sb3.play.seeds import MOST_SEED

MOST_EPISODES = 2**62  # far below the end of int64


@contextmanager
def placed(prefix: str = "", source: str | Path = "snapshot") -> Iterator[None]:
    """Say of a part that is broken where it lies: in which file, and in which group of its arrays."""
    try:
        yield
    except CheckpointError as error:
        place = f"{prefix}/{error.place}" if prefix else error.place
        raise CheckpointError(source, place, found=error.found, expected=error.expected) from error


def check_origin(snapshot: Snapshot, own: NDArray[np.str_]) -> None:
    """Check that games come from this scenario, these rules and these bots.

    Raises:
        ConfigError: they come from others.
        CheckpointError: it is not said where they come from.
    """
    origin = snapshot.get("origin")
    if not isinstance(origin, np.ndarray) or origin.dtype.kind != "U" or origin.shape != own.shape:
        refuse("origin", "something else", "names of rules, scenario and bots")
    for mine, its in zip(own, origin, strict=True):
        if mine != its:
            raise ConfigError(f"these games were saved with {shortened(its)}, this env has {mine}")


def check_games(
    snapshot: Snapshot, arena: Arena, slots: Mapping[str, NDArray[Any]], parts: Iterable[str]
) -> tuple[State, Rows, Rows]:
    """Check the arena's part, and the form of the env's own arrays.

    Args:
        snapshot: to check.
        arena: that is to play on.
        slots: the env's own arrays, with a value a game.
        parts: names of the arrays that others check.

    Returns:
        Copies of the state, the missions and the drives.

    Raises:
        CheckpointError: an array is broken, missing or unknown.
    """
    names = list(arena.snapshot())
    check_names(snapshot, [*names, *slots, *parts, "counters", "origin"])
    for name, array in slots.items():
        check_form(name, snapshot[name], array.dtype, array.shape)
    check_form("counters", snapshot["counters"], np.int64, (2,))
    for number, most in zip(snapshot["counters"], (MOST_SEED, MOST_EPISODES), strict=True):
        check_range("counters", number, 0, most)
    check_range("episodes", snapshot["episodes"], 0, MOST_EPISODES)  # -1: no game has begun there
    check_range("camps", snapshot["camps"], 0, 1)
    return arena.check({name: snapshot[name] for name in names})


def check_opponents(opponents: NDArray[np.int64], players: int) -> None:
    """Check that every opponent is one of so many players.

    Raises:
        ConfigError: there are too few players.
        CheckpointError: a number is none.
    """
    check_range("opponents", opponents, 0, MOST_EPISODES)
    least = int(opponents.max()) + 1
    if players < least:
        raise ConfigError(
            f"these games were saved with {least} opponents or more, this env has {players}: set them first"
            " (SelfPlayCallback.seat does)"
        )


def check_seats(snapshot: Snapshot, drives: Rows, bots: NDArray[np.int64], *, keeps_answers: bool) -> None:
    """Check that the learner, or who shows it a game, sits where the env has it.

    Args:
        snapshot: with `camps` [n].
        drives: of the games [n].
        bots: that sit in the learner's seat, EXTERNAL where none does [n].
        keeps_answers: the learner gives directions beside its tasks.

    Raises:
        CheckpointError: somebody else sits there.
    """
    camps = snapshot["camps"]
    seats = drives.seat[np.arange(len(camps)), camps]
    check_all("drives.seat", seats == bots, seats, "nobody but the learner, or the bot that shows a game")
    learns = np.arange(2) == camps[:, None]
    asked = (drives.seat == EXTERNAL) | learns
    check_all("drives.asked", drives.asked == asked, drives.asked, "1 for the learner, and where no bot sits")
    may_keep = keeps_answers | ~learns
    check_all("drives.lower", (drives.lower != KEPT) | may_keep, drives.lower, "a lower level that is asked")
