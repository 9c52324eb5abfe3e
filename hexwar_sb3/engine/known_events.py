"""A camp's own record of a game: its orders, its views, and the events that it could see."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.record import STATE_TICKS, Line
from hexwar_sb3.engine.roster import Roster, parse_camp
from hexwar_sb3.engine.view import known_now
from hexwar_sb3.kernels import Rows
from hexwar_sb3.rules.enums import Camp

Follow = Callable[[Game, Line, int], None]

_ACTS = frozenset({"orders", "edit", "decision"})
_NAMES = ("piece", "target", "shooter")
_OWN_ONLY = frozenset({"mortar_fired", "mortar_landed", "refused"})
DICE = frozenset({"roll", "raw", "correction_roll", "modifiers", "correction"})
"""A modifier may tell of an unseen piece beside the target, so a camp's record has no dice."""


def known_lines(camp: str, game: Game, lines: Sequence[Line], follow: Follow) -> Iterator[Line]:
    """Play the game again and write what the camp may know, tick by tick.

    follow: makes the game do what a line of the full replay says.
    """
    side, end_tick = parse_camp(camp), min(lines[-1]["tick"], game.world.scenario.game_ticks)
    acts = deque((n, line) for n, line in enumerate(lines, start=1) if line["type"] in _ACTS)
    known: dict[str, Any] = {}
    while game.tick <= end_tick:
        while acts and acts[0][1]["tick"] == game.tick:
            number, line = acts.popleft()
            follow(game, line, number)
            if line.get("camp") == camp:
                yield {key: value for key, value in line.items() if key != "reward"}
        now = known_now(side, game.state, 0, game.world)
        if now != known:
            yield {"type": "known", "tick": game.tick, **_changes(known, now)}
            known = now
        if game.tick % STATE_TICKS == 0 or game.tick == end_tick:
            yield {"type": "view"} | game.view(camp).as_dict()
        if game.tick == end_tick or game.over:
            break
        before = game.state.memory[0, side].copy()
        for event in game.advance(1):
            if is_known(event, side, game.roster, before, game.state.memory[0, side]):
                yield _plain_event(event)
    view = game.view(camp)
    yield {"type": "end", "tick": view.tick, "over": view.over, "own": {camp: view.own_total}}


def _changes(before: dict[str, Any], now: dict[str, Any]) -> dict[str, Any]:
    """The pieces, and the other values, that are not as before."""
    pieces = [piece for piece in now["pieces"] if piece not in before.get("pieces", ())]
    return {
        "pieces": pieces,
        **{name: now[name] for name in now if name != "pieces" and now[name] != before.get(name)},
    }


def is_known(event: GameEvent, camp: Camp, roster: Roster, before: Rows, after: Rows) -> bool:
    """Whether the camp could see the event: every enemy in it, before and after (or dying).

    before, after: the camp's memory [P] around the step.
    """
    names = [getattr(event, name) for name in _NAMES]
    indices = [roster.index(name) for name in names if name is not None]
    if event.kind in _OWN_ONLY and roster.camps[indices[0]] != camp:
        return False
    enemies = [i for i in indices if roster.camps[i] != camp]
    return all(before[i].seen and (after[i].seen or after[i].blood == 0) for i in enemies)


def _plain_event(event: GameEvent) -> Line:
    shown = {name: value for name, value in event.as_dict().items() if name not in DICE}
    return {"type": "event"} | shown
