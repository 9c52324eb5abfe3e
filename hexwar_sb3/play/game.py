"""One game by orders, alone or against a player that is seated in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import cast

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine import game as by_orders
from hexwar_sb3.engine.edit import Editor
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.roster import camp_name, parse_camp
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Row
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.decisions import DecisionLog
from hexwar_sb3.play.recording import play_turn
from hexwar_sb3.players.player import Seat, make_player, seat_name
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.rules import RuleSet
from hexwar_sb3.rules.enums import Camp


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
        ConfigError: the opponent is for other pieces, tasks or features; from `submit`, the camp is the opponent's.

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

    def _write(self, camp: Camp, order: Order, row: Row) -> int:
        if self._seat is not None and camp != self.side:
            raise ConfigError(
                f"{seat_name(self._seat)} gives the orders of {camp_name(camp)}; expected orders for {camp_name(self.side)}"
            )
        return super()._write(camp, order, row)

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
            tick = self.tick
            events += play_turn(self._arena, self.recorder, self._decisions, until, self._given)
            self._given = self._given if self.tick == tick else {}
        self.recorder.note_states(self.state, 0, self.tick)
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
