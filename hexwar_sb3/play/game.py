"""One game by orders, alone or against a player that is seated in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import cast

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine import game as by_orders
from hexwar_sb3.engine.edit import Editor
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.roster import camp_name, parse_camp
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.decisions import DecisionLog
from hexwar_sb3.play.drive import make_step, next_decision, note_due, take_turn
from hexwar_sb3.play.records import STEPS, WAITS
from hexwar_sb3.players.player import Seat, make_player, seat_name
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.rules import RuleSet
from hexwar_sb3.rules.enums import Camp

_GAME = np.zeros(1, np.int64)  # the one of the arena


class Game(by_orders.Game):
    """One game of a scenario, with fog for whoever asks through `view`.

    Orders are for the current tick; time moves only in `advance`. What a camp may know comes from
    `view`, `legal_orders` and `why_illegal`; everything else is the referee's.

    Args:
        scenario: a built-in scenario's name, a path, or a Scenario.
        seed: of all dice; the same seed and orders give the same game.
        ruleset: other rules than the rule book's.
        opponent: a player as `make_player` takes them, which plays the other camp in `advance`; None: both camps
            get their orders by `submit`.
        side: the camp that gets orders, where there is an opponent.

    Raises:
        UnknownNameError: no such scenario, opponent or camp.
        ConfigError: the opponent is for other pieces, tasks or features.

    Example:
        >>> game = Game("plain", seed=0, opponent="MA2", side="red")
        >>> game.submit("red", "tank0 move 1134 1234")
        [None]
        >>> len(game.advance(1800)) > 100
        True
        >>> game.outcome
        'blue'
    """

    def __init__(
        self,
        scenario: ScenarioLike = "plain",
        seed: int = 0,
        ruleset: RuleSet | None = None,
        *,
        opponent: object = None,
        side: str = "red",
    ) -> None:
        super().__init__(scenario, seed, ruleset)
        self.side, self._seat = parse_camp(side), None if opponent is None else make_player(opponent)
        if self._seat is not None:
            self._arena = self._new_arena(self._seat)
            self._decisions = DecisionLog(self._arena)

    def _new_arena(self, seat: Seat) -> Arena:
        """The state of this game, with the opponent in its seat."""
        arena = Arena(self.world, 1, replace(trained_terms(seat), scenario=self.world.scenario))
        arena.state = self.state
        red, blue = (None, seat) if self.side == Camp.RED else (seat, None)
        arena.begin(0, self.seed, red, blue)
        arena.leave(0, self.side)
        return arena

    def submit(
        self, camp: str, orders: Order | str | Iterable[Order | str], *, strict: bool | None = None
    ) -> list[str | None]:
        """Give orders for the current tick; a later order for a piece replaces its earlier one.

        Args:
            camp: whose orders they are; not the opponent's.
            orders: one, or several; as objects or as text, in which a line or ";" ends an order.
            strict: an illegal order raises, and none is taken. If not, it is taken as null and noted in the
                replay: without a word if False, with an `IllegalOrderWarning` if nothing is said.

        Returns:
            For each order why it will be refused, or None.

        Raises:
            ConfigError: the camp is the opponent's.
            OrderError, UnknownNameError: an order that cannot be read or (`strict`) is illegal; then none is taken.
        """
        if self._seat is not None and parse_camp(camp) != self.side:
            raise ConfigError(
                f"{seat_name(self._seat)} gives the orders of {camp}; expected orders for {camp_name(self.side)}"
            )
        return super().submit(camp, orders, strict=strict)

    def advance(self, ticks: int = 1) -> list[GameEvent]:
        """Play so many ticks, at most to the end of the game; an opponent plays them too.

        Returns:
            What happened, in order: the referee's view.

        Raises:
            ConfigError: not a whole number, or below 0: time does not run backwards.
        """
        if self._seat is None:
            return super().advance(ticks)
        until = min(self.tick + check_whole("ticks", ticks, least=0), int(self._row.end_tick))
        events = list[GameEvent]()
        while self.tick < until and not self.over:
            events += self._take_turn(until)
        self.recorder.note_states(self.state, 0, self.tick)
        return events

    def _take_turn(self, until: int) -> list[GameEvent]:
        """Let the opponent act, then make a step or, where nobody has an order, jump to where something is due."""
        arena, world, tick = self._arena, self.world, self.tick
        game, pieces, memory, paths, rounds, orders, log = self.state.game(0)
        drive, missions, brains = arena.drives[0], arena.missions[0], arena.brains[0]
        rules, atlas = world.rules[0], arena.atlas[0]
        self._decisions.ask()
        decides = next_decision(drive, game)
        turn = take_turn(
            min(until, decides), drive, game, pieces, memory, paths, rounds, orders, missions, brains,
            rules, world.cells, world.los, world.eta, atlas, arena.nets,
        )  # fmt: skip
        if turn == WAITS:
            arena.answer(_GAME)
            return []
        for line in self._decisions.lines(tick):
            self.recorder.note_line(self.state, 0, line)
        events = list[GameEvent]()
        if turn == STEPS:
            self.recorder.before_step(self.state, 0, self._given)
            make_step(drive, game, pieces, memory, paths, rounds, orders, log, rules, world.cells, world.los)
            events, self._given = self.recorder.after_step(self.state, 0), {}
        if turn == STEPS or self.tick == decides:
            note_due(drive, game, missions)
        return events

    def copy(self) -> Game:
        """An independent game in the same state; dice and opponent included, it goes on in the same way."""
        other = cast("Game", super().copy())
        if self._seat is not None:
            other._arena = self._arena.twin(other.state)  # noqa: SLF001 - of the same class
            other._decisions = self._decisions.twin(other._arena)  # noqa: SLF001
        return other

    @contextmanager
    def edit(self) -> Iterator[Editor]:
        """Change the position by hand; checked on exit, and left as it was if it is impossible.

        Raises:
            ConfigError: a value or position that the rules do not have, or an opponent, which would not know of it.
        """
        if self._seat is not None:
            raise ConfigError("a game with an opponent cannot be edited: the opponent would not know of it")
        with super().edit() as editor:
            yield editor
