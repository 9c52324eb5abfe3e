"""Indirect fire: launch, landing, burst (rule book, section 9)."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.dice import die, two_dice
from hexwar_sb3.engine.events import note, note_shot
from hexwar_sb3.engine.fire import add_result, clamp
from hexwar_sb3.engine.pieces import count_in, in_motion, on_map, spend_round, stands_in
from hexwar_sb3.engine.records import (
    NEVER,
    NO_CELL,
    NO_PIECE,
    ROUND_BURSTING,
    ROUND_FLYING,
    ROUND_FREE,
    GameRecord,
    Log,
    Orders,
    PieceRecord,
    Pieces,
    RoundRecord,
    Rounds,
)
from hexwar_sb3.engine.sight import has_line, sees_itself
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart, frame_direction
from hexwar_sb3.rules.compiled import NO_EFFECT, SCATTER_HIT, RulesRecord
from hexwar_sb3.rules.enums import Action, Dice, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, camp_range, piece_range

_ONE = np.uint64(1)
_OBSERVER_SEES, _OBSERVER_LOOKS, _NO_OBSERVER = 2, 1, 0


@kernel
def launch(
    i: PieceIndex,
    cell: CellIndex,
    game: GameRecord,
    pieces: Pieces,
    rounds: Rounds,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """Fire the mortar at a cell: the round flies from now on."""
    piece = pieces[i]
    for r in range(rounds.size):
        if rounds[r].owner != i or rounds[r].status != ROUND_FREE:
            continue
        shell = rounds[r]
        shell.camp = piece.camp
        shell.status = ROUND_FLYING
        shell.blood_at_launch = piece.blood
        shell.hit = 0
        shell.cell = cell
        shell.impact = NO_CELL
        shell.launch_cells = cells_apart(cells, piece.cell, cell)
        shell.fired_at = game.tick
        shell.land_at = game.tick + rules.flight_ticks
        shell.end_at = game.tick + rules.burst_ticks
        for side in camp_range(2):
            shell.judged[side] = np.uint64(0)
        break
    spend_round(piece, Weapon.MORTAR, rules)
    piece.mortar_ends = game.tick + rules.mortar_cool_ticks
    ends = game.tick + rules.cool_ticks
    piece.cool_ends = ends if piece.cool_ends == NEVER else max(int(piece.cool_ends), ends)
    piece.hidden = 0
    note(game, log, Event.MORTAR_FIRED, i, NO_PIECE, cell, 0)


@kernel
def cancel_rounds(orders: Orders, rounds: Rounds) -> None:
    """A move order of the owner before landing, in the last step of the flight too, loses the round."""
    for r in range(rounds.size):
        order = orders[rounds[r].owner]
        moves = order.kind == Action.MOVE and order.code == Code.OK
        if moves and rounds[r].status == ROUND_FLYING:
            rounds[r].status = ROUND_FREE


@kernel
def observer_class(
    camp: CampIndex, cell: CellIndex, pieces: Pieces, rules: RulesRecord, cells: Cells, los: Sightlines
) -> int:
    """Correction class of a landing: does an own piece see an enemy there, or look there at all?"""
    best = _NO_OBSERVER
    for i in piece_range(pieces.size):
        if pieces[i].camp != camp or not on_map(pieces[i]):
            continue
        if not has_line(pieces[i].kind, pieces[i].cell, PieceType.TANK, cell, cells, los):
            continue
        for j in piece_range(pieces.size):
            if pieces[j].camp != camp and pieces[j].cell == cell and sees_itself(pieces[i], pieces[j]):
                return _OBSERVER_SEES
        if cells_apart(cells, pieces[i].cell, cell) <= rules.observer_cells:
            best = _OBSERVER_LOOKS
    return best


@kernel
def land_rounds(
    game: GameRecord,
    pieces: Pieces,
    rounds: Rounds,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
) -> None:
    """Rounds whose flight ends with this step: scatter, and judge everybody in the impact cell."""
    for r in range(rounds.size):
        shell = rounds[r]
        if shell.status != ROUND_FLYING or shell.land_at > game.tick + 1:
            continue
        _scatter(shell, game, pieces, rules, cells, los)
        note(game, log, Event.MORTAR_LANDED, shell.owner, NO_PIECE, shell.impact, shell.hit)
        for i in piece_range(pieces.size):
            if stands_in(pieces[i], shell.impact):
                judge(i, shell, game, pieces, log, rules, cells)


@kernel
def _scatter(
    shell: RoundRecord, game: GameRecord, pieces: Pieces, rules: RulesRecord, cells: Cells, los: Sightlines
) -> None:
    owner = pieces[shell.owner]
    column = clamp((shell.launch_cells - 1) // rules.scatter_band_cells, 0, rules.scatter.shape[2] - 1)
    roll = two_dice(game, game.tick, Dice.SCATTER, owner, owner, 0)
    seen = observer_class(shell.camp, shell.cell, pieces, rules, cells, los)
    away = int(rules.scatter[seen, roll, column])
    shell.status = ROUND_BURSTING
    shell.hit = 1 if away == SCATTER_HIT else 0
    shell.impact = shell.cell
    face = die(game, game.tick, Dice.SCATTER_DIRECTION, owner, owner, 0)
    direction = frame_direction(face - 1, shell.camp)
    for _ in range(max(away, 0)):
        beyond = cells[shell.impact].neighbour[direction]
        if beyond == NO_CELL:
            break
        shell.impact = beyond


@kernel
def judge(
    i: PieceIndex,
    shell: RoundRecord,
    game: GameRecord,
    pieces: Pieces,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """Throw for one piece in the impact cell, own or enemy; once a burst."""
    piece = pieces[i]
    bit = _ONE << np.uint64(piece.slot)
    if shell.judged[piece.camp] & bit != 0:
        return
    shell.judged[piece.camp] |= bit
    owner = pieces[shell.owner]
    roll = two_dice(game, game.tick, Dice.INDIRECT, owner, piece, 0)
    raw = int(rules.burst_result[shell.hit, roll])
    roll2 = die(game, game.tick, Dice.INDIRECT_CORRECTION, owner, piece, 0)
    mods = burst_mods(piece, shell.blood_at_launch, pieces, rules, cells)
    corr = int(rules.burst_correction[clamp(roll2 + mods, 0, rules.burst_correction.size - 1)])
    result = max(NO_EFFECT, raw + corr)
    add_result(piece, result)
    note(game, log, Event.MORTAR_JUDGED, shell.owner, i, shell.impact, shell.hit)
    note_shot(game, log, Weapon.MORTAR, 0, roll, raw, roll2, mods, corr, result, shell.launch_cells)


@kernel
def burst_mods(piece: PieceRecord, guns: int, pieces: Pieces, rules: RulesRecord, cells: Cells) -> int:
    """Sum of the modifiers for a piece under a burst."""
    mods = int(rules.burst_armour[rules.armour[piece.kind]])
    mods += rules.burst_guns[min(guns, rules.burst_guns.size - 1)]
    if cells[piece.cell].concealed:
        mods += rules.burst_concealed
    if piece.hidden:
        mods += rules.burst_hidden
    if piece.kind == PieceType.SOLDIER and in_motion(piece):
        mods += rules.burst_soldier_moving
    if count_in(pieces, piece.camp, piece.cell) >= 2:
        mods += rules.burst_stacked
    return mods


@kernel
def judge_entering(
    game: GameRecord,
    pieces: Pieces,
    rounds: Rounds,
    log: Log,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """Judge the pieces that came into a bursting cell in this step."""
    for r in range(rounds.size):
        if rounds[r].status != ROUND_BURSTING:
            continue
        for i in piece_range(pieces.size):
            if pieces[i].came_now and stands_in(pieces[i], rounds[r].impact):
                judge(i, rounds[r], game, pieces, log, rules, cells)
    for i in piece_range(pieces.size):
        pieces[i].came_now = 0
