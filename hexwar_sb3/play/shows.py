"""Who plays the learner's seat while it watches: bots, and people or others whose recorded games are played again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.bots.registry import BOTS, is_bot
from hexwar_sb3.engine.fields import check_all, check_form, check_range, refuse
from hexwar_sb3.engine.replay_file import SUFFIX, replays_of
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError, UnknownNameError, shortened
from hexwar_sb3.play.recorded import RecordedGame
from hexwar_sb3.play.records import EXTERNAL
from hexwar_sb3.play.reenact import read_recorded
from hexwar_sb3.players.player import POLICIES, BotPlayer, Seat, make_player, with_weight
from hexwar_sb3.rules.enums import Camp

NOBODY = -1  # the learner plays itself
Show: TypeAlias = BotPlayer | RecordedGame
SHOWN_DIGITS = 16  # of a hash, in messages
_MOST_TURNS = 2**62


@dataclass(frozen=True)
class _Entry:
    """What was named once: a bot, a file or a folder, by the numbers of its shows for each camp."""

    shows: Mapping[Camp, tuple[int, ...]]
    weight: float


class Demonstrations:
    """What a learner may watch, and whose turn it is.

    Args:
        demo: a bot's name, a replay file, a folder of them, a list of these, or of (one, weight); None: nothing.
        world: of the learner's games.
        camps: that it plays; somebody must show one of them.
        fog: as in its games; recorded ones were played under fog.

    Raises:
        UnknownNameError: there is no such bot, file or folder.
        ConfigError: one is neither a bot nor replays, a weight is out of its range, nobody shows these camps, or replays
            are to be watched without fog.
        ReplayFileError: a file is damaged, or of other games than these; before any of them is played.
    """

    def __init__(self, demo: object, world: World, camps: Sequence[Camp], *, fog: bool = True) -> None:
        if not fog and any(is_replays(one) for one, _ in _entries(demo)):
            raise ConfigError(
                "recorded games were played under fog: where fog is False, demo may be bots alone"
            )
        self.shows: list[Show] = []
        self._entries = [self._entry(one, weight, world) for one, weight in _entries(demo)]
        # All recorded games, in their order.
        self.games = [one for one in self.shows if isinstance(one, RecordedGame)]
        self.turns = np.zeros((len(self._entries), len(SIDES)), np.int64)  # games shown so far [entry, camp]
        shown = {camp for entry in self._entries for camp in SIDES if entry.shows[camp] and entry.weight}
        if demo is not None and shown.isdisjoint(camps):
            names = " nor ".join(map(camp_name, camps))
            raise ConfigError(f"demo: nobody shows how to play {names}: {shortened(repr(demo))}")

    def _entry(self, one: object, weight: float, world: World) -> _Entry:
        first = len(self.shows)
        self.shows += _shows_of(one, world)
        numbers = range(first, len(self.shows))
        shows = {camp: tuple(k for k in numbers if _shows(self.shows[k], camp)) for camp in SIDES}
        return _Entry(shows, weight)

    def draw(self, camp: Camp, rng: np.random.Generator) -> int:
        """The show of the next game of a camp, or NOBODY: an entry by its weight, and of that each game in turn."""
        weights = np.array([entry.weight * bool(entry.shows[camp]) for entry in self._entries])
        if not weights.sum() > 0:
            return NOBODY
        able = np.flatnonzero(weights)
        entry = int(able[0] if len(able) == 1 else rng.choice(len(weights), p=weights / weights.sum()))
        games, turn = self._entries[entry].shows[camp], self.turns[entry, camp]
        self.turns[entry, camp] += 1
        return games[turn % len(games)]

    def recorded(self, show: int) -> RecordedGame | None:
        """The recorded game of a show; None for a bot's and for NOBODY."""
        found = None if show == NOBODY else self.shows[show]
        return found if isinstance(found, RecordedGame) else None

    def seats(self, show: int, camp: Camp, rival: Seat | None) -> tuple[Seat | None, Seat | None]:
        """Who sits where (red, blue) while a show is played, or a game of the learner's own."""
        found = None if show == NOBODY else self.shows[show]
        if isinstance(found, RecordedGame):
            return found.seats(camp)
        return (found, rival) if camp == Camp.RED else (rival, found)

    def bot(self, show: int, camp: int) -> int:
        """The bot's id in the seat of the camp that is shown; EXTERNAL where none sits there."""
        seat = self.seats(show, Camp(camp), None)[camp]
        return seat.bot if isinstance(seat, BotPlayer) else EXTERNAL

    # --- in a checkpoint -------------------------------------------------------------------------

    @property
    def alone(self) -> bool:
        """One bot shows all there is to show, or nobody: nothing has to be remembered."""
        return len(self.shows) <= 1 and not self.games

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What is to be remembered: whose turn it is, and which games these are."""
        if self.alone:
            return {}
        return {"demo_turns": self.turns.copy(), "demo_games": self._names}

    @property
    def _names(self) -> NDArray[np.str_]:
        """Bots by name, recorded games by the hash of what they hold."""
        return np.array([one.name if isinstance(one, BotPlayer) else one.sha256 for one in self.shows])

    def check(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Check what `snapshot` gave.

        Raises:
            ConfigError: these are other games.
            CheckpointError: it is broken.
        """
        if self.alone:
            return
        found: Any = parts["demo_games"]  # of a file
        if not isinstance(found, np.ndarray) or found.dtype.kind != "U" or found.ndim != 1:
            refuse("demo_games", "something else", "hashes of recorded games")
        own = self._names.tolist()
        for k, name in enumerate(own):
            if name not in found.tolist():
                raise ConfigError(f"these games were saved without the demonstration {self._place(k)}")
        if own != found.tolist():
            raise ConfigError(
                f"these games were saved with {len(found)} demonstrations, this env has {len(own)}:"
                " name the same bots and files as before, in the same order"
            )
        check_form("demo_turns", parts["demo_turns"], np.int64, self.turns.shape)
        check_range("demo_turns", parts["demo_turns"], 0, _MOST_TURNS)

    def _place(self, k: int) -> str:
        one = self.shows[k]
        return one.name if isinstance(one, BotPlayer) else f"{one.source} ({one.sha256[:SHOWN_DIGITS]})"

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Go on where `snapshot` was taken."""
        if not self.alone:
            self.turns[...] = parts["demo_turns"]

    def check_shown(
        self, shown: NDArray[np.int64], camps: NDArray[np.int64], seeds: NDArray[np.uint64]
    ) -> None:
        """Check that each game is one that its show plays: of that camp, with those dice [n].

        Raises:
            CheckpointError: it is not.
        """
        check_range("shown", shown, NOBODY, len(self.shows) - 1)
        for b, show in enumerate(shown.tolist()):
            own = self.recorded(show)
            fits = own is None or (camps[b] in own.shows and int(seeds[b]) == own.seed)
            check_all(
                "shown", np.array(fits), show, "a recorded game with these dice, and a camp that it shows"
            )


def _entries(demo: object) -> list[tuple[object, float]]:
    if demo is None:
        return []
    found = [with_weight(one) for one in (demo if isinstance(demo, list | tuple) else [demo])]
    weights = np.array([weight for _, weight in found])
    if not (weights >= 0).all() or not 0 < weights.sum() < np.inf:
        raise ConfigError(f"demo needs finite weights >= 0 with a positive sum, got {shortened(str(demo))}")
    return found


def _shows(show: Show, camp: Camp) -> bool:
    return isinstance(show, BotPlayer) or camp in show.shows


def _shows_of(one: object, world: World) -> list[Show]:
    if is_replays(one):
        return [read_recorded(path, world) for path in replays_of(Path(str(one)))]
    if isinstance(one, str) and not is_bot(one) and one not in POLICIES:
        raise UnknownNameError("bot, replay or folder", one, BOTS)
    player = make_player(one) if isinstance(one, str | BotPlayer) else None
    if not isinstance(player, BotPlayer):
        raise ConfigError(
            f"demo is a bot, which runs in the drive loop, or replays (*{SUFFIX}) or a folder of them;"
            f" got {shortened(repr(one))}"
        )
    return [player]


def is_replays(one: object) -> bool:
    """Whether this is the path of a replay file or of a folder, and no bot's name."""
    named = isinstance(one, str | Path) and one != "" and not is_bot(one)
    return named and (Path(str(one)).suffix == SUFFIX or Path(str(one)).is_dir())
