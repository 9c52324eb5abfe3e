"""A batch of games of one world, all advanced in one compiled call."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields

import numpy as np
import numpy.typing as npt

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.order_rows import write_order
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.roster import Roster, parse_camp
from hexwar_sb3.engine.score import margin
from hexwar_sb3.engine.sound import check_state
from hexwar_sb3.engine.state import State, new_state, reset_game
from hexwar_sb3.engine.step import advance
from hexwar_sb3.engine.view import SideView, side_view
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.rules import RuleSet


class Engine:
    """Games side by side; game b of a batch is the same game as alone, bit for bit.

    Example:
        >>> engine = Engine("plain", n_games=16)
        >>> engine.reset(range(16))
        >>> engine.submit(3, "red", [Move("tank0", ["1134"])])
        >>> engine.advance(75)
        >>> engine.margins("red")[:4]
        array([-130, -130, -130, -130])
    """

    def __init__(
        self, scenario: ScenarioLike = "plain", n_games: int = 1, ruleset: RuleSet | None = None
    ) -> None:
        self.world = load_world(scenario, ruleset)
        self.roster = Roster(self.world.scenario)
        self.state = new_state(self.world, n_games)

    def __len__(self) -> int:
        return int(self.state.games.size)

    def reset(self, seeds: Sequence[int]) -> None:
        """Put every game back to tick 0, each with its seed."""
        for b, seed in zip(range(len(self)), seeds, strict=True):
            reset_game(self.state, b, self.world, seed)

    def submit(self, b: int, camp: str, orders: Iterable[Order]) -> None:
        """Give orders in game b for its current tick.

        Raises:
            OrderError, UnknownNameError: an order that cannot be read.
        """
        side = parse_camp(camp)
        for order in orders:
            i = self.roster.own_index(side, order.piece)
            row = self.state.orders[b, i]
            write_order(order, i, row, self.roster, self.state.pieces[b], self.world.cells)

    def advance(self, ticks: int) -> None:
        """Play so many ticks in every game, at most to its end."""
        s = self.state
        until = s.games.tick.astype(np.int64) + check_whole("ticks", ticks, least=0)
        arrays = (s.games, s.pieces, s.memory, s.paths, s.rounds, s.orders, s.log)
        advance_all(until, *arrays, *self.world.tables)

    def margins(self, camp: str) -> npt.NDArray[np.int64]:
        """The true margin of a camp in every game [B]."""
        side, rules, s = parse_camp(camp), self.world.rules[0], self.state
        pairs = zip(s.games, s.pieces, strict=True)
        return np.array([margin(game, pieces, side, rules) for game, pieces in pairs], np.int64)

    def view(self, b: int, camp: str) -> SideView:
        """All that a camp of game b may know."""
        return side_view(parse_camp(camp), self.state, b, self.world)

    def snapshot(self, b: int) -> State:
        """A copy of game b, about 4 KB."""
        copy = new_state(self.world, 1)
        copy.copy_from(self.state, 0, b)
        return copy

    def restore(self, b: int, snapshot: State) -> None:
        """Put game b back to a snapshot of any batch of the same world.

        Raises:
            CheckpointError: it is no game of this world.
        """
        start = new_state(self.world, 1)
        arrays = {field.name: getattr(snapshot, field.name) for field in fields(State)}
        self.state.copy_from(check_state(self.world, arrays, start, start), b, 0)


@kernel
def advance_all(
    until: Rows, games: Rows, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows,
    log: Rows, rules: Row, cells: Rows, los: Rows,
) -> None:  # fmt: skip
    """Play game b to the state of tick until[b], for all b."""
    for b in range(games.size):
        advance(
            until[b], games[b], pieces[b], memory[b], paths[b], rounds[b], orders[b], log[b], rules,
            cells, los,
        )  # fmt: skip
