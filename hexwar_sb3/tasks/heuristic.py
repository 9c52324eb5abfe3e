"""The heuristic lower level: where a task is best done, and the cheapest next hop to that place.

An answer of the lower level is 0, stay here and perform, or direction + 1 (architecture.md,
section 3). Whoever replaces it answers the same question from the same arguments.
"""

from __future__ import annotations

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.engine.records import NO_CELL, Memory, PieceRecord, Pieces
from hexwar_sb3.engine.sight import sees_itself
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import NO_DIRECTION, cells_apart, frame_direction
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex
from hexwar_sb3.tasks.known import armed_level, would_see
from hexwar_sb3.tasks.progress import is_at_target
from hexwar_sb3.tasks.records import Missions, TaskKind
from hexwar_sb3.tasks.travel import UNREACHABLE, next_direction, travel_ticks

GOOD_LEVEL = 5  # attack level at which a place is good enough to shoot from
SEARCH_CELLS = 30  # how far along the way a place is looked for
SHADOW_CHOICES = 6  # places that a shadowing piece compares for cover

_UNFIT = 0.0


@kernel
def heuristic_direction(
    i: PieceIndex,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
    eta: TravelTimes,
) -> int:
    """Answer of the lower level for piece i: 0 stay and perform, else direction + 1.

    Writes the right place, as resolved now, into `missions[i].goal`.
    """
    piece = pieces[i]
    mission = missions[i]
    mission.goal = right_place(i, pieces, memory, missions, rules, cells, los, eta)
    if mission.goal == NO_CELL:
        return 0
    covered = mission.covered == 1
    return 1 + next_direction(piece.kind, piece.camp, piece.cell, mission.goal, covered, rules, cells, eta)


@kernel
def right_place(
    i: PieceIndex,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
    eta: TravelTimes,
) -> CellIndex:
    """The cell where piece i's task is to be done (table of architecture.md, section 3)."""
    mission = missions[i]
    if is_at_target(mission.kind):
        return _place_for_target(i, pieces, memory, missions, rules, cells, los, eta)
    if mission.kind == TaskKind.BOARD:
        return CellIndex(pieces[mission.target].cell)
    if mission.cell != NO_CELL:
        return CellIndex(mission.cell)
    return CellIndex(pieces[i].cell)


@kernel
def fitness(
    i: PieceIndex,
    cell: CellIndex,
    j: PieceIndex,
    task_kind: int,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
) -> float:
    """How well piece i could do a task on enemy j from a cell; 0: not at all, GOOD_LEVEL: well."""
    piece = pieces[i]
    known = memory[piece.camp, j]
    kind = pieces[j].kind
    if task_kind == TaskKind.BOMBARD:
        apart = cells_apart(cells, cell, known.cell)
        in_range = rules.mortar_min_cells <= apart <= rules.mortar_max_cells
        return float(GOOD_LEVEL) if in_range else _UNFIT
    if not would_see(piece.kind, cell, kind, known, rules, cells, los):
        return _UNFIT
    if task_kind == TaskKind.ATTACK:
        return float(armed_level(piece, cell, kind, known.cell, rules, cells))
    if task_kind == TaskKind.SHADOW:
        return 1.0 + cover(cell, cells)
    return float(GOOD_LEVEL)


@kernel
def cover(cell: CellIndex, cells: Cells) -> float:
    """How sheltered a cell is, 0..2."""
    shelter = 1.0 if cells[cell].concealed else 0.0
    return 1.0 - float(cells[cell].exposure) + shelter


@kernel
def _fitness_here(
    i: PieceIndex,
    j: PieceIndex,
    task_kind: int,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
) -> float:
    """The same for the piece's own cell, where what it really sees is known."""
    piece = pieces[i]
    overlooked = memory[piece.camp, j].seen == 1 and not sees_itself(piece, pieces[j])
    if overlooked and task_kind != TaskKind.BOMBARD:
        return _UNFIT
    return fitness(i, piece.cell, j, task_kind, pieces, memory, rules, cells, los)


@kernel
def _place_for_target(
    i: PieceIndex,
    pieces: Pieces,
    memory: Memory,
    missions: Missions,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
    eta: TravelTimes,
) -> CellIndex:
    """Here if it will do, else the first good cell on the way to where the enemy was last seen."""
    piece = pieces[i]
    mission = missions[i]
    j = mission.target
    target_cell = memory[piece.camp, j].cell
    if target_cell == NO_CELL:
        return CellIndex(piece.cell)
    here = _fitness_here(i, j, mission.kind, pieces, memory, rules, cells, los)
    if here >= GOOD_LEVEL or (mission.kind == TaskKind.SHADOW and here > _UNFIT):
        return CellIndex(piece.cell)
    if mission.kind == TaskKind.SHADOW and mission.goal != NO_CELL:
        if fitness(i, mission.goal, j, mission.kind, pieces, memory, rules, cells, los) > _UNFIT:
            return CellIndex(mission.goal)
    if (
        mission.kind == TaskKind.BOMBARD
        and cells_apart(cells, piece.cell, target_cell) < rules.mortar_min_cells
    ):
        return _step_back(piece, target_cell, rules, cells)
    return _best_on_the_way(i, here, pieces, memory, missions, rules, cells, los, eta)


@kernel
def _best_on_the_way(
    i: PieceIndex, here: float, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord, cells: Cells, los: Sightlines,
    eta: TravelTimes,
) -> CellIndex:  # fmt: skip
    """Walk the way in mind and keep the best place; shadows compare only the first few."""
    piece = pieces[i]
    mission = missions[i]
    target_cell = memory[piece.camp, mission.target].cell
    end = approach(piece.kind, piece.camp, piece.cell, target_cell, rules, cells, eta)
    best, best_fitness, choices = CellIndex(piece.cell), here, 0
    cell = CellIndex(piece.cell)
    for _ in range(SEARCH_CELLS):
        d = next_direction(piece.kind, piece.camp, cell, end, mission.covered == 1, rules, cells, eta)
        if d == NO_DIRECTION:
            break
        cell = CellIndex(cells[cell].neighbour[d])
        if cell == target_cell:
            break
        fit = fitness(i, cell, mission.target, mission.kind, pieces, memory, rules, cells, los)
        if fit > best_fitness:
            best, best_fitness = cell, fit
        choices += 1 if fit > _UNFIT else 0
        if best_fitness >= GOOD_LEVEL or (mission.kind == TaskKind.SHADOW and choices >= SHADOW_CHOICES):
            break
    return cell if best_fitness == _UNFIT else best


@kernel
def approach(
    kind: int,
    camp: CampIndex,
    start: CellIndex,
    goal: CellIndex,
    rules: RulesRecord,
    cells: Cells,
    eta: TravelTimes,
) -> CellIndex:
    """The goal, or a neighbour of it that can be reached where itself cannot; else the start."""
    if travel_ticks(kind, start, goal, rules, cells, eta) < UNREACHABLE:
        return goal
    for framed in range(6):
        beside = CellIndex(cells[goal].neighbour[frame_direction(framed, camp)])
        if beside != NO_CELL and travel_ticks(kind, start, beside, rules, cells, eta) < UNREACHABLE:
            return beside
    return start


@kernel
def _step_back(piece: PieceRecord, target_cell: CellIndex, rules: RulesRecord, cells: Cells) -> CellIndex:
    """The neighbour that is farthest from a cell, the quicker one among equals; else here."""
    best = CellIndex(piece.cell)
    most, least_ticks = cells_apart(cells, piece.cell, target_cell), UNREACHABLE
    for framed in range(6):
        d = frame_direction(framed, piece.camp)
        hop = hop_from(piece.kind, piece.cell, d, rules, cells)
        if hop == 0:
            continue
        beside = CellIndex(cells[piece.cell].neighbour[d])
        apart = cells_apart(cells, beside, target_cell)
        if apart > most or (apart == most and best != piece.cell and hop < least_ticks):
            best, most, least_ticks = beside, apart, hop
    return best
