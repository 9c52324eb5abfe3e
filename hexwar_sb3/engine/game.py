"""One game, by orders: the friendly face of the engine."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from copy import copy

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.edit import Editor
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.order_rows import write_order
from hexwar_sb3.engine.orders import Null, Order
from hexwar_sb3.engine.record import Recorder
from hexwar_sb3.engine.records import ORDER
from hexwar_sb3.engine.roster import SIDES, Roster, camp_name, parse_camp
from hexwar_sb3.engine.score import margin
from hexwar_sb3.engine.state import State, new_state, reset_game
from hexwar_sb3.engine.step import next_due, process, set_tick
from hexwar_sb3.engine.text import parse_board, print_game
from hexwar_sb3.engine.view import SideView, side_view
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import OrderError, UnknownNameError
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.rules import RuleSet
from hexwar_sb3.rules.enums import Camp

LOG_ROWS = 4096  # more events than one step can make


class IllegalOrderWarning(UserWarning):
    """An order that will be refused was given to a game whose caller did not say what to do then."""


class Game:
    """One game of a scenario, with fog for whoever asks through `view`.

    Orders are for the current tick; time moves only in `advance`. What a camp may know comes from
    `view`, `legal_orders` and `why_illegal`; everything else is the referee's.

    Args:
        scenario: a built-in scenario's name, a path, or a Scenario.
        seed: of all dice; the same seed and orders give the same game.
        ruleset: other rules than the rule book's.

    Example:
        >>> game = Game("plain", seed=0)
        >>> game.submit("red", "tank0 move 1134 1234")
        [None]
        >>> events = game.advance(75)
        >>> game
        <Game 'plain', seed 0: tick 75 of 1800, margin red -130, blue -130>
    """

    def __init__(
        self, scenario: ScenarioLike = "plain", seed: int = 0, ruleset: RuleSet | None = None
    ) -> None:
        self.world = load_world(scenario, ruleset)
        self.roster = Roster(self.world.scenario)
        self.seed = check_whole("seed", seed, least=0)
        self.state: State = new_state(self.world, 1, LOG_ROWS)
        reset_game(self.state, 0, self.world, self.seed)
        self.recorder = Recorder(self.world)
        self._given: dict[int, Order] = {}

    @classmethod
    def from_text(cls, text: str, seed: int | None = None) -> Game:
        """The position of a text board (`hexwar_sb3.engine.text`).

        Raises:
            ConfigError: names the line that cannot be read, or what is wrong with the position.
        """
        board = parse_board(text)
        game = cls(board.scenario, board.seed if seed is None else seed)
        with game.edit() as state:
            for change in board.changes:
                state.apply(change)
        return game

    # --- the clock -------------------------------------------------------------------------------

    @property
    def _row(self) -> Row:
        return self.state.games[0]

    @property
    def pieces(self) -> Rows:
        """The pieces' records [P], the referee's view."""
        return self.state.pieces[0]

    @property
    def tick(self) -> int:
        """Steps made so far, 0 at the start."""
        return int(self._row.tick)

    @property
    def over(self) -> bool:
        """No more orders are taken."""
        return bool(self._row.over)

    @property
    def outcome(self) -> str | None:
        """Winner of a game that is over, or "draw"; None while it is played."""
        if not self.over:
            return None
        lead = self.margin("red") - self.margin("blue")
        return "draw" if lead == 0 else camp_name(Camp.RED if lead > 0 else Camp.BLUE)

    def margin(self, camp: str) -> int:
        """The referee's true margin of a camp, eq. (1) of the paper, in points."""
        return int(margin(self._row, self.pieces, parse_camp(camp), self.world.rules[0]))

    # --- playing ---------------------------------------------------------------------------------

    def submit(
        self, camp: str, orders: Order | str | Iterable[Order | str], *, strict: bool | None = None
    ) -> list[str | None]:
        """Give orders for the current tick; a later order for a piece replaces its earlier one.

        Args:
            camp: whose orders they are.
            orders: one, or several; as objects or as text, in which a line or ";" ends an order.
            strict: an illegal order raises, and none is taken. If not, it is taken as null and noted in the
                replay: without a word if False, with an `IllegalOrderWarning` if nothing is said.

        Returns:
            For each order why it will be refused, or None.

        Raises:
            OrderError, UnknownNameError: an order that cannot be read or (`strict`) is illegal; then none is taken.

        Example:
            >>> game = Game("plain", seed=0)
            >>> game.submit("red", "tank0 move 1134 1234; chariot0 occupy", strict=False)
            [None, 'red chariot0 stands in 1037, which is no control point; it must stand in one to occupy it']
        """
        side = parse_camp(camp)
        batch = list(_read(orders))
        rows = np.zeros(len(batch), ORDER).view(np.recarray)
        places = [self._write(side, order, row) for order, row in zip(batch, rows, strict=True)]
        advisor = self.advisor(side)
        reasons = [advisor.why_illegal(order) for order in batch]
        refused = [
            f"{camp_name(side)}, {order}: {why}" for order, why in zip(batch, reasons, strict=True) if why
        ]
        if refused and strict:
            raise OrderError(refused[0])
        for said in refused if strict is None else ():
            warnings.warn(f"an illegal order is taken as null: {said}", IllegalOrderWarning, stacklevel=2)
        for i, order, row in zip(places, batch, rows, strict=True):
            self.state.orders[0, i] = row
            self._given[i] = order
        self._given = {i: order for i, order in self._given.items() if not isinstance(order, Null)}
        return reasons

    def _write(self, camp: Camp, order: Order, row: Row) -> int:
        if not isinstance(order, Order):
            raise OrderError(
                f"expected an order such as Move('tank0', ['1134']) or 'tank0 move 1134', found {order!r}"
            )
        i = self.roster.own_index(camp, order.piece)
        write_order(order, i, row, self.roster, self.pieces, self.world.cells)
        return i

    def advance(self, ticks: int = 1) -> list[GameEvent]:
        """Play so many ticks, at most to the end of the game.

        Returns:
            What happened, in order: the referee's view.

        Raises:
            ConfigError: not a whole number, or below 0: time does not run backwards.
        """
        until = min(self.tick + check_whole("ticks", ticks, least=0), int(self._row.end_tick))
        rows, tables, events = self.state.game(0), self.world.tables, list[GameEvent]()
        while self.tick < until and not self.over:
            if not self._given:  # jump to the next step that matters
                due = int(next_due(self._row, self.pieces, self.state.rounds[0]))
                set_tick(self._row, min(due, until), self.pieces)
            if self.tick < until:
                self.recorder.before_step(self.state, 0, self._given)
                process(*rows, *tables)
                events += self.recorder.after_step(self.state, 0)
                self._given = {}
        self.recorder.note_states(self.state, 0, self.tick)
        return events

    # --- what a camp may know --------------------------------------------------------------------

    def view(self, camp: str) -> SideView:
        """All that a camp may know now."""
        return side_view(parse_camp(camp), self.state, 0, self.world)

    def legal_orders(self, camp: str, piece: str) -> tuple[Order, ...]:
        """Every legal order of a piece now; of moves those of one hop, of shots with their chances."""
        side = parse_camp(camp)
        return self.advisor(side).legal_orders(self.roster.own_index(side, piece))

    def why_illegal(self, camp: str, order: Order | str) -> str | None:
        """Why the order would be refused now, as a sentence; None if it is legal."""
        try:
            given = Order.parse(order) if isinstance(order, str) else order
            return self.advisor(camp).why_illegal(given)
        except (OrderError, UnknownNameError) as error:
            return str(error)

    def advisor(self, camp: str | Camp) -> Advisor:
        """Who judges orders of a camp in this state, by what the camp knows."""
        return Advisor(parse_camp(camp), self._row, self.pieces, self.state.memory[0], self.world)

    # --- the whole game as a value ---------------------------------------------------------------

    def copy(self) -> Game:
        """An independent game in the same state; dice included, it goes on in the same way."""
        other = copy(self)
        other.state = new_state(self.world, 1, LOG_ROWS)
        other.state.copy_from(self.state, 0, 0)
        other.recorder = self.recorder.copy()
        other._given = dict(self._given)  # noqa: SLF001 - of the same class
        return other

    @contextmanager
    def edit(self) -> Iterator[Editor]:
        """Change the position by hand; checked on exit, and left as it was if it is impossible.

        Raises:
            ConfigError: a value or position that the rules do not have.
        """
        self.recorder.note_states(
            self.state, 0, self.tick
        )  # as it is played again: first the state, then the edit
        before = new_state(self.world, 1)
        before.copy_from(self.state, 0, 0)
        editor = Editor(self.state, self.world)
        try:
            yield editor
            editor.finish()
        except BaseException:
            self.state.copy_from(before, 0, 0)
            raise
        if editor.changes:
            self.recorder.note_edit(self.tick, editor.changes)

    def __str__(self) -> str:
        return print_game(self.state, 0, self.world)

    def __repr__(self) -> str:
        name, end = self.world.scenario.name, int(self._row.end_tick)
        margins = ", ".join(f"{camp} {self.margin(camp):+}" for camp in map(camp_name, SIDES))
        over = f", {self.outcome}" if self.over else ""
        return f"<Game {name!r}, seed {self.seed}: tick {self.tick} of {end}, margin {margins}{over}>"


def _read(orders: Order | str | Iterable[Order | str]) -> Iterator[Order]:
    """Orders one by one; what is no order comes out as it is, and is refused by its place."""
    if isinstance(orders, str):
        yield from (Order.parse(line) for line in orders.replace(";", "\n").splitlines() if line.strip())
    elif isinstance(orders, Iterable):
        for order in orders:
            if isinstance(order, str):
                yield from _read(order)
            else:
                yield order
    else:
        yield orders
