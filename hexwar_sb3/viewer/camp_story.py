"""What one camp may know of a game, as a story: made of its views, its orders and the events that it could see.

Nothing else reaches a teller, so nothing else can come out: no seed, no dice, no true margin, no enemy order, and no
list whose length depends on what the camp did not see.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.known_events import DICE, is_known
from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.records import ROUND_BURSTING
from hexwar_sb3.engine.roster import Roster, parse_camp
from hexwar_sb3.engine.view import SideView
from hexwar_sb3.kernels import Rows
from hexwar_sb3.viewer.decisions import told_decisions
from hexwar_sb3.viewer.tracks import CampTracks, Json

DULL = frozenset({"arrived", "refused"})  # the tracks and the orders have them


class CampTeller:
    """Looks at a game tick by tick with the eyes of one camp."""

    view: SideView  # the last one in which anything was new

    def __init__(self, camp: str, roster: Roster) -> None:
        self.camp, self.side, self.roster = camp, parse_camp(camp), roster
        self.tracks = CampTracks(camp, roster)
        self.events: list[Json] = []
        self.last = 0
        self._looked_at = b""
        self._memory: Rows | None = None

    def look(self, game: Game, events: Sequence[GameEvent]) -> bool:
        """The game at one tick more, and the events that led there; says whether the camp found anything new."""
        memory = game.state.memory[0, self.side]
        before = memory if self._memory is None else self._memory
        known = (event for event in events if is_known(event, self.side, self.roster, before, memory))
        self.events += [_told(event) for event in known if event.kind not in DULL]
        self._memory = memory.copy()
        self.last = game.tick
        found = self._fingerprint(game)
        if found == self._looked_at:
            return False  # a view takes its time, and mostly nothing is new
        self._looked_at = found
        self.view = game.view(self.camp)
        self.tracks.note(self.view)
        return True

    def _fingerprint(self, game: Game) -> bytes:
        """Bytes of all that a view is made of, but the clock."""
        state, own = game.state, game.world.side(self.side)
        row, pieces, memory, rounds = (  # not as records, which are slow to take apart
            np.asarray(rows)[0] for rows in (state.games, state.pieces, state.memory, state.rounds)
        )
        shown = rounds[(rounds["camp"] == self.side) | (rounds["status"] == ROUND_BURSTING)]
        known = pieces[own], state.paths[0, own], memory[self.side]
        parts = (*known, shown, row["point_owner"], row["fight_cell"])
        return b"".join(part.tobytes() for part in parts)

    def document(self, lines: Sequence[Line]) -> Json:
        """The camp's story; of the lines of the replay it reads the camp's own orders and decisions."""
        own = [line for line in lines if line.get("camp") == self.camp]
        tracks = self.tracks
        return {
            "view": self.camp,
            "last": self.last,
            "pieces": {name: track.told() for name, track in tracks.own.items()},
            "beliefs": {self.camp: {name: track.told() for name, track in tracks.beliefs.items()}},
            "owners": tracks.owners,
            "known_margin": {self.camp: tracks.known_margin},
            "own_total": {self.camp: tracks.own_total},
            "fights": tracks.fights,
            "bursts": tracks.bursts,
            "rounds": list(tracks.rounds.values()),
            "events": self.events,
            "orders": _told_orders(own),
            **told_decisions(own, self.roster),
        }


def _told_orders(lines: Sequence[Line]) -> list[list[object]]:
    """Orders as `[tick, camp, [order, ...], [[order, why it was refused], ...]]`."""
    given = (line for line in lines if line["type"] == "orders")
    return [[line["tick"], line["camp"], line["orders"], line.get("refused", [])] for line in given]


def _told(event: GameEvent) -> Json:
    return {name: value for name, value in event.as_dict().items() if name not in DICE}
