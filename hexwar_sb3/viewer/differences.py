"""Stories as a page of many games packs them: differences in place of ticks and cells, which are small and repeat themselves.

It makes a block a quarter smaller. `viewer/src/packed.ts` adds them up again.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from hexwar_sb3.viewer.tracks import Json


def with_differences(story: Json) -> Json:
    """A story whose pieces, beliefs, events and orders have differences (docs/formats/story.md, "Packed")."""
    found = dict(story)
    for name, change in (
        ("pieces", _pieces),
        ("beliefs", _beliefs),
        ("events", _events),
        ("orders", _orders),
    ):
        if name in story:
            found[name] = change(story[name])
    return found


def _pieces(pieces: Json) -> Json:
    return {
        name: {field: _field(field, values) for field, values in one.items()} for name, one in pieces.items()
    }


def _beliefs(beliefs: Json) -> Json:
    return {
        camp: {
            name: {field: changes(values, steps=field == "cell") for field, values in one.items()}
            for name, one in enemies.items()
        }
        for camp, enemies in beliefs.items()
    }


def _field(name: str, values: Sequence[Any]) -> list[Any]:
    return hops(values) if name == "hops" else changes(values, ends=name.endswith("_ends"))


def changes(values: Sequence[Any], *, steps: bool = False, ends: bool = False) -> list[Any]:
    """A list of changes with each tick less the one before it.

    Args:
        values: `[tick, value, ...]`.
        steps: a value is less the one before it.
        ends: a value is a tick, and less the tick at which it begins to hold; 0 stays 0.

    Example:
        >>> changes([10, 4, 30, 5], steps=True)
        [10, 4, 20, 1]
        >>> changes([10, 85, 85, 0], ends=True)
        [10, 75, 75, 0]
    """
    found, tick, last = list[Any](), 0, 0
    for at, value in zip(values[::2], values[1::2], strict=True):
        told = value - last if steps else value - at if ends and value else value
        found += [at - tick, told]
        tick, last = at, value
    return found


def hops(values: Sequence[Sequence[int]]) -> list[list[int]]:
    """Hops as ticks since the end of the one before, ticks that each takes, cells from the one before.

    Example:
        >>> hops([[0, 20, 78], [25, 45, 79], [45, 65, 80, 50]])
        [[0, 20, 78], [5, 20, 1], [0, 20, 1, 5]]
    """
    start = [0, 0, 0]
    return [
        [hop[0] - before[1], hop[1] - hop[0], hop[2] - before[2], *(broken - hop[0] for broken in hop[3:])]
        for before, hop in pairwise([start, *values])
    ]


def _events(events: Sequence[Json]) -> list[Json]:
    ticks = [0, *(event["tick"] for event in events)]
    return [{**event, "tick": event["tick"] - before} for before, event in zip(ticks, events, strict=False)]


def _orders(orders: Sequence[Sequence[Any]]) -> list[list[Any]]:
    ticks = [0, *(order[0] for order in orders)]
    return [[order[0] - before, *order[1:]] for before, order in zip(ticks, orders, strict=False)]
