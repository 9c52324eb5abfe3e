"""Orders between their text classes and the records that kernels read, both ways."""

from __future__ import annotations

from hexwar_sb3.engine.orders import (
    ORDERS,
    GetOff,
    GetOn,
    GuideShoot,
    IndirectShoot,
    Move,
    Order,
    Shoot,
)
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, PATH_CELLS
from hexwar_sb3.engine.roster import Roster, enemy_of
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.maps.geometry import DIRECTION_NAMES, NO_DIRECTION, direction_between
from hexwar_sb3.rules.enums import Action, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex

NO_WEAPON = -1
GAP = len(DIRECTION_NAMES)  # direction of a path step to a cell that is no neighbour: never legal
_TOO_LONG = PATH_CELLS + 1  # path_len of every path that does not fit


def write_order(order: Order, i: PieceIndex, row: Row, roster: Roster, pieces: Rows, cells: Rows) -> None:
    """Write the order of piece i into its record.

    Raises:
        OrderError: it names a cell or weapon that does not exist.
        UnknownNameError: it names a piece that does not exist.
    """
    clear_order(row)
    row.kind = order.action
    camp = roster.camps[i]
    match order:
        case Move():
            _write_path(_directions(order, CellIndex(pieces[i].cell), roster, cells), row)
        case Shoot():
            row.target = roster.index_in(enemy_of(camp), order.target)
            row.weapon = Weapon[order.weapon]
        case GuideShoot():
            row.target = roster.index_in(enemy_of(camp), order.target)
            row.partner = roster.index_in(camp, order.chariot)
            row.weapon = Weapon.HEAVY
        case IndirectShoot():
            row.cell = roster.cell(order.cell)
            row.weapon = Weapon.MORTAR
        case GetOn():
            row.target = roster.index_in(camp, order.chariot)
        case GetOff():
            row.target = roster.index_in(camp, order.passenger)


def clear_order(row: Row) -> None:
    """Make the record a null order."""
    row.kind = Action.NULL
    row.code = 0
    row.weapon = NO_WEAPON
    row.target = NO_PIECE
    row.partner = NO_PIECE
    row.path_len = 0
    row.cell = NO_CELL
    row.path[:] = 0


def _write_path(directions: list[int], row: Row) -> None:
    row.path_len = min(len(directions), _TOO_LONG)
    for k, direction in enumerate(directions[:PATH_CELLS]):
        row.path[k] = direction


def _directions(order: Move, start: CellIndex, roster: Roster, cells: Rows) -> list[int]:
    """Directions of a path; GAP where a step names no neighbour."""
    found: list[int] = []
    here = start
    for step in order.path:
        if step in DIRECTION_NAMES:
            direction = DIRECTION_NAMES.index(step)
        else:
            direction = int(direction_between(cells, here, roster.cell(step)))
        if direction == NO_DIRECTION or cells[here].neighbour[direction] == NO_CELL:
            return [*found, GAP]
        found.append(direction)
        here = CellIndex(cells[here].neighbour[direction])
    return found


def read_order(i: PieceIndex, row: Row, roster: Roster, pieces: Rows, cells: Rows) -> Order:
    """The order that a record holds, in words; the path as cell names."""
    piece = roster.short(i)
    match Action(row.kind):
        case Action.MOVE:
            return Move(piece, _cell_names(row, CellIndex(pieces[i].cell), roster, cells))
        case Action.SHOOT:
            return Shoot(piece, roster.names[row.target], Weapon(row.weapon).name)
        case Action.GUIDE_SHOOT:
            return GuideShoot(piece, roster.names[row.target], roster.short(row.partner))
        case Action.INDIRECT_SHOOT:
            return IndirectShoot(piece, roster.cell_name(row.cell))
        case Action.GET_ON:
            return GetOn(piece, roster.short(row.target))
        case Action.GET_OFF:
            return GetOff(piece, roster.short(row.target))
        case action:
            return ORDERS[action](piece)


def _cell_names(row: Row, start: CellIndex, roster: Roster, cells: Rows) -> list[str]:
    """Cells of a path; a step that leads nowhere stays a direction and is the last one."""
    names, here = [], start
    for direction in map(int, row.path[: row.path_len]):
        here = CellIndex(cells[here].neighbour[direction]) if direction < len(DIRECTION_NAMES) else NO_CELL
        if here == NO_CELL:
            break
        names.append(roster.cell_name(here))
    return names
