"""The heuristic lower level: right places and cheapest next hops (table of architecture.md, section 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from hexwar_sb3.engine.fire import level_between
from hexwar_sb3.maps.geometry import NO_DIRECTION, E, W, cells_apart
from hexwar_sb3.rules.enums import Camp, PieceType, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.tasks.heuristic import GOOD_LEVEL, heuristic_direction, right_place
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.travel import UNREACHABLE, next_direction, travel_ticks

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

K = TaskKind


def place(field: Board, name: str) -> CellIndex:
    return right_place(
        field.i(name),
        field.pieces,
        field.memory,
        field.missions,
        field.rules,
        field.cells,
        field.los,
        field.eta,
    )


def answer(field: Board, name: str) -> int:
    return heuristic_direction(
        field.i(name),
        field.pieces,
        field.memory,
        field.missions,
        field.rules,
        field.cells,
        field.los,
        field.eta,
    )


def meet(field: Board, apart: int) -> PieceIndex:
    """A blue chariot some cells east of the red tank; its index."""
    field.put("tank0", field.cell(5, 2))
    field.put("blue:chariot0", field.cell(5 + apart, 2))
    field.look()
    return field.i("blue:chariot0")


@pytest.mark.parametrize("kind", [PieceType.TANK, PieceType.SOLDIER, PieceType.AEROCRAFT])
@pytest.mark.parametrize("covered", [False, True])
def test_next_hops_lead_to_the_goal(board: Board, kind: PieceType, covered: bool) -> None:
    """On the built-in map; the fast way takes exactly the time of the distance field."""
    start, goal = board.cell(10, 34), board.cell(35, 46)
    cell, spent = start, 0
    for _ in range(200):
        d = next_direction(kind, Camp.RED, cell, goal, covered, board.rules, board.cells, board.eta)
        if d == NO_DIRECTION:
            break
        hop_class = 1 if kind == PieceType.SOLDIER else 0
        aerocraft = kind == PieceType.AEROCRAFT
        spent += board.rules.base_hop[kind] if aerocraft else board.cells[cell].hop_ticks[hop_class, d]
        cell = CellIndex(board.cells[cell].neighbour[d])
    fastest = travel_ticks(kind, start, goal, board.rules, board.cells, board.eta)

    assert cell == goal
    assert spent == fastest or (covered and fastest < spent < UNREACHABLE)


def exposure_on_the_way(board: Board, start: CellIndex, goal: CellIndex, covered: bool) -> float:
    cell, seen = start, []
    while cell != goal:
        d = next_direction(PieceType.TANK, Camp.RED, cell, goal, covered, board.rules, board.cells, board.eta)
        cell = CellIndex(board.cells[cell].neighbour[d])
        seen.append(float(board.cells[cell].exposure))
    return float(np.mean(seen))


def test_covered_ways_are_less_exposed(board: Board) -> None:
    goal = board.cell(35, 34)
    starts = [board.cell(x, y) for x in (8, 12, 20) for y in range(10, 60, 5)]
    starts = [cell for cell in starts if board.cells[cell].passable]

    fast, covered = (
        np.mean([exposure_on_the_way(board, cell, goal, c) for cell in starts]) for c in (False, True)
    )

    assert covered < fast


def test_hold_hide_drop_are_done_at_their_cell(field: Board) -> None:
    goal = field.cell(20, 10)
    for kind in (K.HOLD, K.HIDE, K.DROP):
        field.task("chariot0", kind, cell=goal)
        assert place(field, "chariot0") == goal


def test_the_answer_is_the_first_hop_and_0_at_the_place(field: Board) -> None:
    field.put("tank0", field.cell(19, 10))
    mission = field.task("tank0", K.HOLD, cell=field.cell(20, 10))
    assert answer(field, "tank0") == E + 1
    assert mission.goal == field.cell(20, 10)
    field.put("tank0", field.cell(20, 10))
    assert answer(field, "tank0") == 0


def test_an_attack_stays_where_a_weapon_reaches_a_good_level(field: Board) -> None:
    field.task("tank0", K.ATTACK, target=meet(field, 15))  # the gun's level is 5 at 15 cells
    assert answer(field, "tank0") == 0


def test_an_attack_walks_to_the_first_cell_of_a_good_level(field: Board) -> None:
    """The gun has level 5 at 15 cells and 4 at 16."""
    j = meet(field, 18)
    field.task("tank0", K.ATTACK, target=j)
    goal = place(field, "tank0")
    tank, enemy = field.pieces[0], field.memory[0, j]
    levels = [
        level_between(
            Weapon.GUN, tank, CellIndex(cell), PieceType.CHARIOT, enemy.cell, field.rules, field.cells
        )
        for cell in (goal, goal - 1)
    ]

    assert answer(field, "tank0") == E + 1
    assert cells_apart(field.cells, goal, enemy.cell) == 15
    assert levels[0] >= GOOD_LEVEL > levels[1]


def test_a_remembered_enemy_is_attacked_where_it_was_last_seen(field: Board) -> None:
    j = meet(field, 18)
    field.put("blue:chariot0", field.cell(38, 20))
    field.put("tank0", field.cell(1, 2))
    field.memory[0, j].seen = 0
    field.task("tank0", K.ATTACK, target=j)

    assert cells_apart(field.cells, place(field, "tank0"), field.cell(23, 2)) == 15


def test_guiding_is_done_from_where_the_piece_itself_sees_the_target(field: Board) -> None:
    """An aerocraft sees vehicles at 5 cells."""
    j = meet(field, 12)
    field.put("aerocraft0", field.cell(5, 2))
    field.task("aerocraft0", K.GUIDE, target=j)

    assert cells_apart(field.cells, place(field, "aerocraft0"), field.memory[0, j].cell) == 5


def test_a_shadow_stays_once_it_sees_its_target(field: Board) -> None:
    j = meet(field, 20)
    mission = field.task("tank0", K.SHADOW, target=j)
    assert answer(field, "tank0") == 0
    field.put("tank0", field.cell(1, 20))
    field.pieces[0].sees = 0
    mission.goal = field.cell(8, 2)
    assert place(field, "tank0") == field.cell(8, 2)  # a place that still serves is kept


@pytest.mark.parametrize(("apart", "stays"), [(3, False), (4, True), (20, True), (21, False)])
def test_a_bombardment_keeps_its_distance(field: Board, apart: int, stays: bool) -> None:
    field.put("chariot0", field.cell(8, 2))
    field.put("blue:tank0", field.cell(8 + apart, 2))
    field.look()
    field.task("chariot0", K.BOMBARD, target=field.i("blue:tank0"))

    direction = answer(field, "chariot0")

    assert (direction == 0) == stays
    if apart == 21:
        assert direction == E + 1
    elif not stays:
        assert direction == W + 1


def test_boarding_leads_to_the_chariot(field: Board) -> None:
    field.land("soldier0")
    field.put("chariot0", field.cell(20, 2))
    field.task("soldier0", K.BOARD, target=field.i("chariot0"))
    assert place(field, "soldier0") == field.cell(20, 2)
