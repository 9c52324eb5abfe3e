"""How long the way to a cell is, and its next hop: read off the distance fields, no search."""

from __future__ import annotations

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, TravelTimes
from hexwar_sb3.maps.geometry import NO_DIRECTION, cells_apart, frame_direction
from hexwar_sb3.maps.travel import TOO_FAR, row_to
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import HopClass, PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex

UNREACHABLE = 32000  # ticks; more than any game lasts
CONCEALED_SHELTER = 0.3  # what concealment takes off the cost of a covered way (bots.md, section 1)


@kernel
def travel_ticks(
    kind: int, start: CellIndex, goal: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes
) -> int:
    """Fastest time of a type of piece from one cell to another, ticks; UNREACHABLE: no way."""
    return ticks_by(ways_to(kind, goal, rules, cells, eta), kind, start, goal, rules, cells, eta)


@kernel
def ways_to(kind: int, goal: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes) -> int:
    """The row of all ways of a type of piece to a cell, for `ticks_by`; whoever flies needs none."""
    if kind == PieceType.AEROCRAFT:
        return 0
    hop_class = HopClass.SOLDIER if kind == PieceType.SOLDIER else HopClass.VEHICLE
    return row_to(hop_class, goal, rules, cells, eta)


@kernel
def ticks_by(
    row: int, kind: int, start: CellIndex, goal: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes
) -> int:
    """`travel_ticks` by the row of the goal, which is looked up once for many starts."""
    base = int(rules.base_hop[kind])
    if kind == PieceType.AEROCRAFT:
        return base * cells_apart(cells, start, goal)
    hops = int(eta[row, start])
    return UNREACHABLE if hops == TOO_FAR else base * hops


@kernel
def hop_cost(cell: CellIndex, hop: int, covered: bool, cells: Cells) -> float:
    """Cost of a hop into a cell: its ticks, on a covered way weighed by how exposed the cell is."""
    if not covered:
        return float(hop)
    shelter = CONCEALED_SHELTER if cells[cell].concealed else 0.0
    return float(hop) * (1.0 + float(cells[cell].exposure) - shelter)


@kernel
def next_direction(
    kind: int,
    camp: CampIndex,
    start: CellIndex,
    goal: CellIndex,
    covered: bool,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
) -> int:
    """Direction of the cheapest next hop to a cell, ties in the camp's frame; NO_DIRECTION: none.

    A covered way only takes hops that shorten the way, so it arrives too.
    """
    best = NO_DIRECTION
    best_cost = float(UNREACHABLE)
    if start == goal:
        return best
    row = ways_to(kind, goal, rules, cells, eta)
    from_here = ticks_by(row, kind, start, goal, rules, cells, eta)
    for framed in range(6):
        d = frame_direction(framed, camp)
        hop = hop_from(kind, start, d, rules, cells)
        if hop == 0:
            continue
        cell = cells[start].neighbour[d]
        rest = ticks_by(row, kind, cell, goal, rules, cells, eta)
        cost = rest + hop_cost(cell, hop, covered, cells)
        if rest < from_here and cost < best_cost:
            best, best_cost = d, cost
    return best
