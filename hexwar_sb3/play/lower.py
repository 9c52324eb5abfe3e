"""The lower level in the drive loop: the heuristic, a network, a kept direction, or somebody outside.

Whoever answers, the question is the same: a piece with a task stands at a cell's centre, and is told to stay
and perform, or one of six directions (III-A).
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.pieces import hop_from
from hexwar_sb3.engine.records import NO_CELL, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.maps.geometry import frame_direction
from hexwar_sb3.play.records import DriveRecord
from hexwar_sb3.players.route_network import best_answer, route_values
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.execute import needs_answer
from hexwar_sb3.tasks.features import ROUTE_WIDTH
from hexwar_sb3.tasks.heuristic import right_place
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.progress import can_end, end_task
from hexwar_sb3.tasks.records import STAYING, WALKING, MissionRecord, Missions, TaskKind
from hexwar_sb3.tasks.route import N_ANSWERS, STAY, has_way, observe_route

HEURISTIC, KEPT = 0, -1  # drive.lower; k > 0 is network k - 1


@kernel
def asks(mission: MissionRecord) -> bool:
    """Kinds of tasks for which a piece may have to go somewhere."""
    return mission.kind != TaskKind.STOP and mission.kind != TaskKind.RECOVER


@kernel
def note_answer(answer: int, piece: PieceRecord, mission: MissionRecord, tick: int) -> None:
    """Keep an answer, 0 or a direction in the camp's frame + 1, until the next cell or decision."""
    mission.asked_at = tick
    mission.direction = STAY if answer == STAY else 1 + frame_direction(answer - 1, piece.camp)
    mission.state = STAYING if answer == STAY else WALKING


@kernel
def ask_network(
    piece: PieceRecord, mission: MissionRecord, net: Row, rules: RulesRecord, cells: Cells, eta: TravelTimes
) -> int:
    """The network's answer for a piece on its way to `mission.goal`."""
    state, mask = np.zeros(ROUTE_WIDTH, np.float32), np.zeros(N_ANSWERS, np.int8)
    observe_route(
        piece.kind,
        piece.camp,
        mission.kind,
        piece.cell,
        mission.goal,
        net.ways == 1,
        rules,
        cells,
        eta,
        state,
        mask,
    )
    q = np.zeros(N_ANSWERS, np.float32)
    route_values(state, net, q)
    return best_answer(q, mask, net.tie)


@kernel
def kept_answer(
    i: PieceIndex, drive: DriveRecord, piece: PieceRecord, rules: RulesRecord, cells: Cells
) -> int:
    """The direction that the piece was told to keep; staying once it cannot go on."""
    answer = int(drive.kept[i])
    if answer != STAY:
        direction = frame_direction(answer - 1, piece.camp)
        if hop_from(piece.kind, piece.cell, direction, rules, cells) == 0:
            drive.kept[i] = STAY
    return int(drive.kept[i])


@kernel
def answer_piece(
    i: PieceIndex, drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord, cells: Cells, los: Sightlines,
    eta: TravelTimes, nets: Rows,
) -> None:  # fmt: skip
    """Answer for piece i, or mark it as waiting for somebody outside."""
    piece, mission = pieces[i], missions[i]
    mission.goal = right_place(i, pieces, memory, missions, rules, cells, los, eta)
    lower = drive.lower[piece.camp]
    if mission.goal == NO_CELL or not has_way(piece.kind, piece.cell, mission.goal, rules, cells, eta):
        note_answer(STAY, piece, mission, game.tick)
    elif drive.outside[i]:
        drive.waiting[i] = 1
    elif lower == KEPT:
        note_answer(kept_answer(i, drive, piece, rules, cells), piece, mission, game.tick)
    else:
        note_answer(
            ask_network(piece, mission, nets[lower - 1], rules, cells, eta), piece, mission, game.tick
        )


@kernel
def is_answered(camp: CampIndex, drive: DriveRecord, game: GameRecord) -> bool:
    """Whether anybody but the heuristic answers for some piece of the camp."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if drive.outside[i]:
            return True
    return drive.lower[camp] != HEURISTIC


@kernel
def answer_pieces(
    camp: CampIndex, drive: DriveRecord, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord, cells: Cells, los: Sightlines,
    eta: TravelTimes, nets: Rows,
) -> bool:  # fmt: skip
    """Answer for the camp's pieces that ask, where it is not the heuristic that does; False: somebody waits."""
    waits = False
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        drive.waiting[i] = 0
        if drive.lower[camp] == HEURISTIC and not drive.outside[i]:
            continue
        if can_end(pieces[i], missions[i]):
            end_task(i, game, pieces, memory, missions, rules)
        if asks(missions[i]) and needs_answer(pieces[i], missions[i], game.tick):
            answer_piece(i, drive, game, pieces, memory, missions, rules, cells, los, eta, nets)
            waits |= drive.waiting[i] == 1
    return not waits


@kernel
def tell_pieces(
    which: Rows, numbers: Rows, answers: Rows, drives: Rows, games: Rows, pieces: Rows, missions: Rows
) -> None:
    """Give answers[k] to piece numbers[k] of game which[k], which waits for it."""
    for k in range(which.size):
        b, i = which[k], numbers[k]
        note_answer(answers[k], pieces[b, i], missions[b, i], games[b].tick)
        drives[b].waiting[i] = 0
