"""The policy layer of a replay: per decision what each piece could do, what it chose, and what its values were."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.viewer.tracks import Json


def told_decisions(lines: Sequence[Line], roster: Roster) -> Json:
    """The entries `tasks` and `decisions` of a camp's story; nothing where a replay has no such lines.

    A decision is `[tick, [[piece, chosen, tasks, Q in thousandths, direction], ...]]`; a task is a number in `tasks`.
    """
    tasks: dict[str, int] = {}

    def told(camp: str, piece: str, chosen: int, texts: list[str], q: list[int], way: str) -> list[Any]:
        numbers = [tasks.setdefault(text, len(tasks)) for text in texts]
        return [roster.index(f"{camp}:{piece}"), chosen, numbers, q, way]

    rows = [
        [line["tick"], [told(line["camp"], *choice) for choice in line.get("choices", [])]]
        for line in _decisions(lines)
    ]
    return {"tasks": list(tasks), "decisions": rows} if rows else {}


def told_rewards(lines: Sequence[Line]) -> Json:
    """The entry `rewards` of the referee's story: `[tick, camp, {term: points}]`.

    They tell of losses that a camp did not see, so no camp's story has them.
    """
    rows = [[line["tick"], line["camp"], line["reward"]] for line in _decisions(lines) if "reward" in line]
    return {"rewards": rows} if rows else {}


def _decisions(lines: Sequence[Line]) -> list[Line]:
    return [line for line in lines if line["type"] == "decision"]
