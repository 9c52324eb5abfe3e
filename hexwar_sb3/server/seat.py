"""The seat of a person: what each piece was told to do, now and then, and which of it is due."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.orders import Order, Stop
from hexwar_sb3.engine.pieces import has_path
from hexwar_sb3.engine.roster import Roster, parse_camp
from hexwar_sb3.errors import OrderError
from hexwar_sb3.kernels import Row
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.server.steps import MOST_STEPS, Go, Step, read_steps
from hexwar_sb3.server.ways import find_way, move_along

PASSES = frozenset(
    {
        *(Code.BUSY, Code.MOVING, Code.SUPPRESSED, Code.COOLING),
        *(Code.BETWEEN_CELLS, Code.ABOARD, Code.PARTNER_BUSY),
    }
)
"""Reasons that go by: a step that was planned for later waits for them."""


@dataclass(frozen=True)
class Plan:
    """What a piece is to do."""

    steps: tuple[Step, ...]
    order: Order | None = None  # for the first step, in the tray: judged already, given in the next tick


class Refused(NamedTuple):
    """An order that was not carried out."""

    piece: str
    order: str
    why: str


class PersonSeat:
    """Holds the plans of one camp's pieces until they are due.

    Example:
        >>> seat = PersonSeat(Game("plain", seed=0), "red")
        >>> seat.plan("tank0", ("tank0 go 1134", "tank0 hide"))
        >>> seat.tray(), seat.told()
        ({'tank0': 'tank0 move 1134'}, {'tank0': ['tank0 go 1134', 'tank0 hide']})
    """

    def __init__(self, game: Game, camp: str) -> None:
        self.game, self.camp = game, parse_camp(camp)
        self.roster: Roster = game.roster
        self.plans: dict[str, Plan] = {}
        self._before: list[dict[str, Plan]] = []  # for `undo`

    # --- what is planned -------------------------------------------------------------------------

    def plan(self, piece: str, texts: tuple[str, ...], *, then: bool = False) -> None:
        """Let a piece do these steps, in place of what was planned or (`then`) after it.

        Raises:
            OrderError, UnknownNameError: a step that cannot be read, or that the engine would refuse now.
        """
        advisor = self.game.advisor(self.camp)
        self._own(piece)
        steps = read_steps(piece, texts, advisor)
        if then:
            new = self._appended(piece, steps)
        else:
            new = self._begun(piece, steps, advisor)
        self._change(piece, new)

    def _appended(self, piece: str, steps: tuple[Step, ...]) -> Plan:
        plan = self.plans.get(piece, Plan(()))
        if len(plan.steps) + len(steps) > MOST_STEPS:
            found = len(plan.steps) + len(steps)
            raise OrderError(f"the plan of {piece} would have {found} steps; expected at most {MOST_STEPS}")
        return replace(plan, steps=plan.steps + steps)

    def _begun(self, piece: str, steps: tuple[Step, ...], advisor: Advisor) -> Plan:
        """A plan whose first step can be given now."""
        if isinstance(steps[0], Go) and has_path(self._row(piece)):
            steps = (Stop(piece), *steps)
        order = self._order(steps[0])
        if order is None:
            raise OrderError(f"{steps[0]}: {piece} stands there already; expected another cell")
        why = advisor.why_illegal(order)
        if why is not None:
            raise OrderError(why)
        return Plan(steps, order)

    def cancel(self, piece: str) -> None:
        """Forget what was planned for a piece.

        Raises:
            OrderError, UnknownNameError: it is none of the camp's.
        """
        self._own(piece)
        self._change(piece, None)

    def undo(self) -> None:
        """Take back the last change since the clock ran.

        Raises:
            OrderError: there is none.
        """
        if not self._before:
            raise OrderError("nothing to take back: no plan was made since the clock ran")
        self.plans = self._before.pop()

    @property
    def undoes(self) -> int:
        """How often `undo` has something to take back."""
        return len(self._before)

    def _change(self, piece: str, new: Plan | None) -> None:
        self._before.append(self.plans)
        others = {name: plan for name, plan in self.plans.items() if name != piece}
        self.plans = others if new is None else others | {piece: new}

    def restore(self, plans: Mapping[str, tuple[str, ...]]) -> None:
        """Plans as they were kept: of pieces that have none now, to go on when they are due.

        Raises:
            OrderError, UnknownNameError: they are none of this camp.
        """
        advisor = self.game.advisor(self.camp)
        for piece in plans:
            self._own(piece)
        self.plans = {piece: Plan(read_steps(piece, texts, advisor)) for piece, texts in plans.items()}

    # --- what is told of it ----------------------------------------------------------------------

    def tray(self) -> dict[str, str]:
        """Orders that are given in the next tick, by piece."""
        return {
            piece: str(plan.order) for piece, plan in sorted(self.plans.items()) if plan.order is not None
        }

    def told(self) -> dict[str, list[str]]:
        """What comes after them, by piece; a waypoint stands there until the piece has arrived."""
        waiting = {
            piece: plan.steps if plan.order is None else _rest(plan.steps)
            for piece, plan in self.plans.items()
        }
        return {piece: list(map(str, steps)) for piece, steps in sorted(waiting.items()) if steps}

    def kept(self) -> dict[str, list[str]]:
        """All steps, by piece: what `restore` takes."""
        return {piece: list(map(str, plan.steps)) for piece, plan in sorted(self.plans.items())}

    # --- the clock -------------------------------------------------------------------------------

    def due(self) -> tuple[list[Order], list[Refused]]:
        """The orders of the tick to come, and the steps that are refused now that they are due; then plans go on."""
        self._before = []
        orders, refused = list[Order](), list[Refused]()
        advisor = self.game.advisor(self.camp) if self.plans else None
        for piece in sorted(self.plans):
            try:
                orders += self._due(piece, cast("Advisor", advisor))
            except OrderError as error:
                refused.append(Refused(piece, str(self.plans[piece].steps[0]), str(error)))
                self.drop(piece)
        return orders, refused

    def drop(self, piece: str) -> None:
        """Forget the plan of a piece, without a way back."""
        self._set(piece, ())

    def _due(self, piece: str, advisor: Advisor) -> Iterator[Order]:
        """The order that the piece's plan has for it now, if any."""
        if self._row(piece).blood == 0:
            self.drop(piece)
            return
        order = self.plans[piece].order or self._next_order(piece, advisor)
        if order is not None:
            self._set(piece, _rest(self.plans[piece].steps))
            yield order

    def _next_order(self, piece: str, advisor: Advisor) -> Order | None:
        """The order of the next step, once the piece has done those before it and no reason that goes by is left.

        Raises:
            OrderError: it is refused for another reason.
        """
        if has_path(self._row(piece)):
            return None
        order = self._first_undone(piece)
        code, why = (Code.OK, None) if order is None else advisor.judge(order)
        if why is not None and code not in PASSES:
            raise OrderError(why)
        return order if why is None else None

    def _first_undone(self, piece: str) -> Order | None:
        """The order of the first step that is not done; those before it are gone from the plan."""
        steps = self.plans[piece].steps
        for n, step in enumerate(steps):
            order = self._order(step)
            if order is not None:
                self._set(piece, steps[n:])
                return order
        self.drop(piece)
        return None

    def _set(self, piece: str, steps: tuple[Step, ...]) -> None:
        others = {name: plan for name, plan in self.plans.items() if name != piece}
        self.plans = others | ({piece: Plan(steps)} if steps else {})

    def _order(self, step: Step) -> Order | None:
        """The order for a step; None for a waypoint where the piece is."""
        if isinstance(step, Order):
            return step
        i = self._own(step.piece)
        here, goal = CellIndex(int(self.game.pieces[i].cell)), self.roster.cell(step.cell)
        if here == goal:
            return None
        way = find_way(i, here, goal, self.game.world)
        return move_along(way, step.piece, self.roster, int(self.game.world.rules[0].path_limit))

    def _own(self, piece: str) -> PieceIndex:
        i = self.roster.own_index(self.camp, piece)
        if self.roster.short(i) != piece:
            raise OrderError(f"{piece!r}: expected the name of an own piece without its camp, like tank0")
        return i

    def _row(self, piece: str) -> Row:
        return self.game.pieces[self._own(piece)]


def _rest(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """What is left when the first step is given: a waypoint stays until it is reached."""
    return steps if isinstance(steps[0], Go) else steps[1:]
