"""Ways of pieces, by the engine's own routes: read off its tables of travel times, hop by hop."""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.engine.orders import Move
from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import OrderError
from hexwar_sb3.maps.geometry import NO_DIRECTION
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.tasks.travel import next_direction


@dataclass(frozen=True)
class Way:
    """The fastest way of a piece to a cell."""

    cells: tuple[CellIndex, ...]  # without the first
    hop_ticks: tuple[int, ...]  # of the hop into each of them


def find_way(i: PieceIndex, start: CellIndex, goal: CellIndex, world: World) -> Way:
    """The way of piece i from one cell to another.

    Raises:
        OrderError: there is none.
    """
    kind, camp = int(world.scenario.pieces[i].kind), world.scenario.pieces[i].camp
    rules, cells, _ = world.tables
    here, way, ticks = start, list[CellIndex](), list[int]()
    while here != goal:
        direction = int(next_direction(kind, camp, here, goal, False, rules, cells, world.eta))
        if direction == NO_DIRECTION:
            raise OrderError(_no_way(i, start, goal, world))
        ticks.append(int(hop_from(kind, here, direction, rules, cells)))
        here = CellIndex(int(cells[here].neighbour[direction]))
        way.append(here)
    return Way(tuple(way), tuple(ticks))


def _no_way(i: PieceIndex, start: CellIndex, goal: CellIndex, world: World) -> str:
    roster = Roster(world.scenario)
    kind = world.scenario.pieces[i].kind.name.lower()
    ends = f"from {roster.cell_name(start)} to {roster.cell_name(goal)}"
    return f"{roster.spoken(i)} has no way {ends}; every hop must lead to a neighbour that a {kind} can enter"


def move_along(way: Way, piece: str, roster: Roster, most_cells: int) -> Move:
    """The order that walks a way, or as much of it as an order may hold."""
    return Move(piece, [roster.cell_name(cell) for cell in way.cells[:most_cells]])
