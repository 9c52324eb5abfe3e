"""What the lower level reads: one piece, its goal and the six cells around it, in the order of features.py.

The paper's state for route planning is the six neighbours' properties (III-A, "State representation"). They
cannot show what lies behind a ridge, so the fastest ways over the known map, which the altitude
differences shape (III-C, "Preprocessing"), stand beside them; `ways` leaves them out.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import NO_CELL, Cells, TravelTimes
from hexwar_sb3.maps.geometry import cells_apart, frame_direction
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.indices import CampIndex, CellIndex
from hexwar_sb3.tasks.features import MOST, PER_DETOUR, PER_HOP, PER_LEVEL, ROUTE_WIDTH
from hexwar_sb3.tasks.task_rows import N_TASKS, N_TYPES, put_way
from hexwar_sb3.tasks.travel import UNREACHABLE, ticks_by, travel_ticks, ways_to

N_ANSWERS = 7  # stay and perform, or one of six directions in the camp's frame (III-A)
STAY = 0

_GOAL = N_TYPES + N_TASKS  # first number of the goal
_HERE, _WAY, _NEIGHBOUR = _GOAL + 3, _GOAL + 4, _GOAL + 5
_PER_NEIGHBOUR = 9


@kernel
def observe_route(
    kind: int, camp: CampIndex, task: int, cell: CellIndex, goal: CellIndex, ways: bool, rules: RulesRecord, cells: Cells, eta: TravelTimes,
    out: Rows, mask: Rows,
) -> None:  # fmt: skip
    """Write the state of the lower level and its valid answers (III-A, "State representation").

    Args:
        kind: PieceType; camp: Camp; task: TaskKind.
        cell: where the piece is.
        goal: the right place of its task.
        ways: also the fastest ways to the goal, from here and from the neighbours.
        out: f4 [Dl].
        mask: i1 [7]: a direction is valid where the piece can go, staying in the right place (elsewhere there is
            nothing to perform) and where it can go nowhere.
    """
    out[:] = 0.0
    mask[:] = 0
    out[kind] = 1.0
    out[N_TYPES + task] = 1.0
    put_way(out, _GOAL, camp, cell, goal, cells)
    out[_HERE] = 1.0 if cell == goal else 0.0
    row = ways_to(kind, goal, rules, cells, eta)
    way = ticks_by(row, kind, cell, goal, rules, cells, eta)
    if ways:
        out[_WAY] = min(way * PER_HOP / rules.base_hop[kind], MOST)
    stuck = True
    for framed in range(6):
        d = frame_direction(framed, camp)
        if cells[cell].neighbour[d] == NO_CELL:
            continue
        at = _NEIGHBOUR + framed * _PER_NEIGHBOUR
        hop = _put_neighbour(out, at, kind, cell, d, goal, rules, cells)
        if hop > 0:
            stuck = False
            mask[1 + framed] = 1
            if ways:
                neighbour = cells[cell].neighbour[d]
                detour = hop + ticks_by(row, kind, neighbour, goal, rules, cells, eta) - way
                out[at + 8] = max(-MOST, min(MOST, detour * PER_DETOUR / rules.base_hop[kind]))
    mask[STAY] = 1 if cell == goal or stuck else 0


@kernel
def _put_neighbour(
    out: Rows,
    at: int,
    kind: int,
    cell: CellIndex,
    direction: int,
    goal: CellIndex,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Properties of the cell in a direction; the ticks of the hop there, 0 if there is none."""
    beside = cells[cell].neighbour[direction]
    there = cells[beside]
    hop = hop_from(kind, cell, direction, rules, cells)
    out[at] = max(-MOST, min(MOST, (int(there.level) - int(cells[cell].level)) * PER_LEVEL))
    out[at + 1] = there.controllable
    out[at + 2] = there.passable
    out[at + 3] = there.paved
    out[at + 4] = there.concealed
    out[at + 5] = there.slushy
    out[at + 6] = rules.base_hop[kind] / hop if hop > 0 else 0.0
    out[at + 7] = cells_apart(cells, cell, goal) - cells_apart(cells, beside, goal)
    return int(hop)


@kernel
def has_way(
    kind: int, cell: CellIndex, goal: CellIndex, rules: RulesRecord, cells: Cells, eta: TravelTimes
) -> bool:
    """A piece of this type can get from a cell to the goal."""
    return travel_ticks(kind, cell, goal, rules, cells, eta) < UNREACHABLE


def new_route_buffers(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Zeroed states f4 [n, Dl] and masks i1 [n, 7]."""
    return np.zeros((n, ROUTE_WIDTH), np.float32), np.zeros((n, N_ANSWERS), np.int8)
