"""All legal orders of a piece, by its camp's own knowledge, and why another one is not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hexwar_sb3.engine.chances import NOT_LEGAL, burst_chances, mortar_classes, shot_chances
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.order_rows import clear_order, read_order, write_order
from hexwar_sb3.engine.orders import GuideShoot, IndirectShoot, Order, Shoot
from hexwar_sb3.engine.reasons import Case, explain
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, ORDER
from hexwar_sb3.engine.roster import Roster, enemy_of
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.maps.geometry import DIRECTION_NAMES, cells_apart
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import Action, PieceType, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex


def known_pieces(camp: int, pieces: Rows, memory: Rows) -> Rows:
    """A copy of the pieces in which the enemies that the camp does not see are not there."""
    known = pieces.copy()
    absent = np.flatnonzero((known.camp != camp) & (memory.seen[camp] == 0))
    known.blood[absent] = 0
    known.cell[absent] = NO_CELL
    known.carrier[absent] = NO_PIECE
    return known


class Advisor:
    """Judges orders of one camp in one state."""

    def __init__(self, camp: int, game: Row, pieces: Rows, memory: Rows, world: World) -> None:
        self.camp, self.game, self.world = camp, game, world
        self.roster = Roster(world.scenario)
        self.pieces = known_pieces(camp, pieces, memory)
        self.rules, self.cells, self.los = world.tables
        self._row = np.zeros(1, ORDER).view(np.recarray)[0]

    def why_illegal(self, order: Order) -> str | None:
        """Why the order would be refused; None if it is legal."""
        return self.judge(order)[1]

    def judge(self, order: Order) -> tuple[Code, str | None]:
        """Code of an order, and the sentence of one that would be refused.

        Raises:
            OrderError, UnknownNameError: it names what does not exist, or a piece of the other camp.
        """
        i = self.roster.own_index(self.camp, order.piece)
        row = self._row
        write_order(order, i, row, self.roster, self.pieces, self.cells)
        row.code = self._code(i)
        code = Code(int(row.code))
        return code, None if code is Code.OK else self.explain(order, i, row)

    def explain(self, order: Order, i: PieceIndex, row: Row) -> str:
        """The sentence for a code that the record holds."""
        return explain(Case(order, i, row, self.game, self.pieces, self.roster, self.rules, self.cells))

    def legal_orders(self, i: PieceIndex) -> tuple[Order, ...]:
        """Every legal order of piece i; of moves, those of one hop."""
        return (*self.orders_by_name(i), *self._mortar_orders(i))

    def orders_by_name(self, i: PieceIndex) -> tuple[Order, ...]:
        """Legal orders of piece i but mortar fire, which is possible at hundreds of cells (`mortar_classes`)."""
        orders = []
        for _ in self._candidates(i):
            if self._code(i) == Code.OK:
                orders.append(self._with_chances(i))
        return tuple(orders)

    def targets(self, i: PieceIndex) -> list[PieceIndex]:
        """Enemies at which piece i may fire now, by itself or as a guide."""
        found = {}
        for action in (Action.SHOOT, Action.GUIDE_SHOOT):
            for _ in self._written(i, action):
                if self._code(i) == Code.OK:
                    found[PieceIndex(int(self._row.target))] = True
        return list(found)

    def _mortar_orders(self, i: PieceIndex) -> Iterator[Order]:
        """Legal mortar orders: too many cells to try them one by one."""
        here, classes = CellIndex(self.pieces[i].cell), self.mortar_classes(i)
        for cell in [CellIndex(c) for c in np.flatnonzero(classes != NOT_LEGAL).tolist()]:
            apart = int(cells_apart(self.cells, here, cell))
            chances = burst_chances(int(classes[cell]), apart, self.rules)
            yield IndirectShoot(self.roster.short(i), self.roster.cell_name(cell), chances)

    def mortar_classes(self, i: PieceIndex) -> Rows:
        """Correction class of a round of piece i at each cell [NC]; NOT_LEGAL where it may not fire."""
        row = self._row
        clear_order(row)
        row.kind = Action.INDIRECT_SHOOT
        return mortar_classes(i, row, self.game, self.pieces, self.rules, self.cells, self.los)

    def _code(self, i: PieceIndex) -> int:
        return int(order_code(i, self._row, self.game, self.pieces, self.rules, self.cells))

    def _candidates(self, i: PieceIndex) -> Iterator[None]:
        """Write one candidate after the other into the scratch record."""
        for action in Action:
            yield from self._written(i, action)

    def _written(self, i: PieceIndex, action: Action) -> Iterator[None]:
        for choice in self._choices(i, action):
            clear_order(self._row)
            self._row.kind = action
            for name, value in choice.items():
                self._row[name] = value
            yield

    def _choices(self, i: PieceIndex, action: Action) -> Iterator[Mapping[str, int]]:
        """Parameters of an action, by field of the record."""
        own, enemies = self.roster.pieces_of(self.camp), self.roster.pieces_of(enemy_of(self.camp))
        match action:
            case Action.MOVE:
                yield from ({"path": d, "path_len": 1} for d in range(len(DIRECTION_NAMES)))
            case Action.SHOOT:
                weapons = self._weapons(i)
                yield from ({"target": t, "weapon": weapon} for t in enemies for weapon in weapons)
            case Action.GUIDE_SHOOT:
                pairs = [(t, c) for t in enemies for c in self._chariots(own)]
                yield from ({"target": t, "partner": c, "weapon": Weapon.HEAVY} for t, c in pairs)
            case Action.INDIRECT_SHOOT:  # `_mortar_orders`
                return
            case Action.GET_ON | Action.GET_OFF:
                yield from ({"target": j} for j in own)
            case _:
                yield {}

    def _weapons(self, i: PieceIndex) -> list[Weapon]:
        pools = self.rules.pool[self.pieces[i].kind]
        return [weapon for weapon in Weapon if pools[weapon] != NO_POOL]

    def _chariots(self, own: Sequence[PieceIndex]) -> list[int]:
        return [i for i in own if self.pieces[i].kind == PieceType.CHARIOT]

    def _with_chances(self, i: PieceIndex) -> Order:
        """The order in the scratch record, with its chances if it is fire."""
        row, tables = self._row, (self.pieces, self.rules, self.cells)
        order = read_order(i, row, self.roster, self.pieces, self.cells)
        if isinstance(order, Shoot):
            chances = shot_chances(row.weapon, self.pieces[i], self.pieces[row.target], *tables)
            return Shoot(order.piece, order.target, order.weapon, chances)
        if isinstance(order, GuideShoot):
            shooter, target = self.pieces[row.partner], self.pieces[row.target]
            chances = shot_chances(Weapon.HEAVY, shooter, target, *tables)
            return GuideShoot(order.piece, order.target, order.chariot, chances)
        return order
