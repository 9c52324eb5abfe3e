"""What a mortar round is worth: expected points over scatter, burst and correction (section 9)."""

from __future__ import annotations

from hexwar_sb3.engine.fire import clamp
from hexwar_sb3.engine.pieces import count_in, in_motion, stands_in
from hexwar_sb3.engine.records import GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import NO_EFFECT, SCATTER_HIT, RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece, is_known, known_in
from hexwar_sb3.tasks.shots import KILL_BONUS, SOLDIER_SUPPRESSED, VEHICLE_SUPPRESSED

_SIDES = 6
_FIRST_BAND = 0  # column of the launch distances 1-20, all that the mortar reaches
_CORRECTED, _UNOBSERVED = 2, 0  # correction classes of a landing


@kernel
def chance_of_two_dice(roll: int) -> float:
    """Chance of the sum of two dice."""
    return (_SIDES - abs(roll - _SIDES - 1)) / (_SIDES * _SIDES)


@kernel
def burst_value(hit: int, kind: int, blood: int, mods: int, rules: RulesRecord) -> float:
    """Expected points that one piece in the impact cell loses; `hit` 0: off target."""
    light = SOLDIER_SUPPRESSED if kind == PieceType.SOLDIER else VEHICLE_SUPPRESSED
    units = 0.0
    for roll in range(2, 2 * _SIDES + 1):
        raw = int(rules.burst_result[hit, roll])
        if raw == NO_EFFECT:
            continue
        for face in range(1, _SIDES + 1):
            m = clamp(face + mods, 0, rules.burst_correction.size - 1)
            losses = raw + int(rules.burst_correction[m])
            gain = light if losses == 0 else float(clamp(losses, 0, blood))
            if losses >= blood:
                gain += KILL_BONUS
            units += gain * chance_of_two_dice(roll) / _SIDES
    return units * float(rules.value[kind])


@kernel
def landing_value(kind: int, blood: int, mods: int, observed: bool, rules: RulesRecord) -> float:
    """Expected points over all scatters of a round aimed at the piece's cell."""
    hit = 0.0
    off_target = 0.0
    for roll in range(2, 2 * _SIDES + 1):
        away = rules.scatter[_CORRECTED if observed else _UNOBSERVED, roll, _FIRST_BAND]
        if away == SCATTER_HIT:
            hit += chance_of_two_dice(roll)
        elif away == 0:
            off_target += chance_of_two_dice(roll)
    value = hit * burst_value(1, kind, blood, mods, rules)
    return value + off_target * burst_value(0, kind, blood, mods, rules)


@kernel
def place_mods(
    kind: int,
    cell: CellIndex,
    hidden: int,
    moving: bool,
    stacked: bool,
    guns: int,
    rules: RulesRecord,
    cells: Cells,
) -> int:
    """Modifiers of the correction for a piece under a burst."""
    mods = int(rules.burst_armour[rules.armour[kind]]) + int(rules.burst_guns[guns])
    if cells[cell].concealed:
        mods += int(rules.burst_concealed)
    if hidden:
        mods += int(rules.burst_hidden)
    if kind == PieceType.SOLDIER and moving:
        mods += int(rules.burst_soldier_moving)
    if stacked:
        mods += int(rules.burst_stacked)
    return mods


@kernel
def mortar_value(
    i: PieceIndex,
    cell: CellIndex,
    observed: bool,
    game: GameRecord,
    pieces: Pieces,
    memory: Memory,
    rules: RulesRecord,
    cells: Cells,
) -> float:
    """Expected points of a round of chariot i at a cell, own losses taken off (bots.md, section 1).

    Args:
        i: the chariot; its blood counts as it is now.
        cell: aimed at; enemies that were last seen there are taken to be there still.
        observed: an own piece will see an enemy in the cell when the round lands.
    """
    camp = pieces[i].camp
    guns = min(int(pieces[i].blood), rules.burst_guns.size - 1)
    value = 0.0
    stacked = known_in(camp, cell, game, pieces, memory) >= 2
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        kind = pieces[j].kind
        if known.cell == cell and is_known(known) and kind != PieceType.AEROCRAFT:
            mods = place_mods(kind, cell, known.hidden, known.moving == 1, stacked, guns, rules, cells)
            value += landing_value(kind, known.blood, mods, observed, rules)
    stacked = count_in(pieces, camp, cell) >= 2
    for a in piece_range(first_piece(camp, game), end_piece(camp, game)):
        own = pieces[a]
        if stands_in(own, cell):
            mods = place_mods(own.kind, cell, own.hidden, in_motion(own), stacked, guns, rules, cells)
            value -= landing_value(own.kind, own.blood, mods, observed, rules)
    return value
