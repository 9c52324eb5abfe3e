"""How a scripted player weighs what it knows: trust, threat, gain, power (bots.md, section 1).

Enemies are read through the camp's memory only. `trust` is the brain's [P], renewed at each thought.
"""

from __future__ import annotations

from hexwar_sb3.bots.config import BotConfig
from hexwar_sb3.bots.records import SPENT, AtlasRecord, BrainRecord
from hexwar_sb3.engine.fire import clamp
from hexwar_sb3.engine.pieces import on_map, target_class, weapon_ammo
from hexwar_sb3.engine.records import GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.engine.score import known_margin, points_value
from hexwar_sb3.engine.sight import has_line, sees_itself
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Camp, PieceType, TargetClass, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.known import (
    end_piece,
    first_piece,
    is_known,
    reach_of_sight,
)


@kernel
def renew_trust(
    camp: CampIndex, game: GameRecord, memory: Memory, brain: BrainRecord, config: BotConfig
) -> None:
    """How much each enemy's last known place still says: 1 seen now, 0 after `trust_ticks` or never seen."""
    brain.n_foes = 0
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        brain.trust[j] = 0.0
        if is_known(known):
            age = 0.0 if known.seen else float(game.tick - known.tick)
            brain.trust[j] = max(0.0, 1.0 - age / config.trust_ticks)
        if brain.trust[j] > 0.0:
            brain.foes[brain.n_foes] = j
            brain.n_foes += 1


@kernel
def exposed_reach(kind: int, target_kind: int, cell: CellIndex, rules: RulesRecord, cells: Cells) -> int:
    """Greatest distance at which a type of piece sees an unhidden piece standing in a cell."""
    reach = int(rules.sight[kind, target_kind])
    if cells[cell].concealed and target_kind != PieceType.AEROCRAFT:
        reach = max(1, reach // int(rules.concealed_sight_divisor))
    return reach


@kernel
def danger_of(
    row: int,
    cell: CellIndex,
    target: int,
    target_cell: CellIndex,
    shelter: int,
    cells: Cells,
    atlas: AtlasRecord,
) -> float:
    """Expected points of a shot of a type of piece (a row of the danger table) from cell to cell."""
    apart = cells_apart(cells, cell, target_cell)
    if apart >= atlas.danger.shape[4]:
        return 0.0
    uphill = clamp(int(cells[target_cell].level) - int(cells[cell].level), 0, atlas.danger.shape[3] - 1)
    return float(atlas.danger[row, target, shelter, uphill, apart])


@kernel
def threat_at(
    kind: int, cell: CellIndex, camp: CampIndex, pieces: Pieces, memory: Memory, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, atlas: AtlasRecord,
) -> float:  # fmt: skip
    """Points that known enemies may be expected to cost an unhidden piece in a cell, one round of shots."""
    total = 0.0
    for n in range(brain.n_foes):
        j = brain.foes[n]
        trust = brain.trust[j]
        known = memory[camp, j]
        enemy = pieces[j].kind
        if cells_apart(cells, cell, known.cell) > exposed_reach(enemy, kind, cell, rules, cells):
            continue
        danger = danger_of(enemy, known.cell, kind, cell, int(cells[cell].concealed), cells, atlas)
        if danger > 0.0 and has_line(enemy, known.cell, kind, cell, cells, los):
            total += trust * danger * known.blood / float(rules.blood[enemy])
    return total


@kernel
def danger_row(piece: PieceRecord, rules: RulesRecord) -> int:
    """Row of the danger table for an own piece: a chariot without missiles is another shooter."""
    if piece.kind == PieceType.CHARIOT and weapon_ammo(piece, Weapon.HEAVY, rules) == 0:
        return SPENT
    return int(piece.kind)


@kernel
def gain_at(
    kind: int, row: int, cell: CellIndex, camp: CampIndex, pieces: Pieces, memory: Memory, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, atlas: AtlasRecord,
) -> float:  # fmt: skip
    """Expected points of the best shot from a cell at a known enemy, plus a share of the second best.

    Args:
        row: row of the danger table, the kind of the shooter or SPENT.
    """
    best, second = 0.0, 0.0
    for n in range(brain.n_foes):
        j = brain.foes[n]
        trust = brain.trust[j]
        known = memory[camp, j]
        target = pieces[j].kind
        if cells_apart(cells, cell, known.cell) > reach_of_sight(kind, cell, target, known, rules, cells):
            continue
        shelter = int(cells[known.cell].concealed) + int(known.hidden)
        value = trust * danger_of(row, cell, target, known.cell, shelter, cells, atlas)
        if value > second and has_line(target, known.cell, kind, cell, cells, los):
            if value > best:
                best, second = value, best
            else:
                second = value
    return best + atlas.config.second_share * second


@kernel
def guided_gain(
    c: PieceIndex, row: int, cell: CellIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord,
    cells: Cells, atlas: AtlasRecord,
) -> float:  # fmt: skip
    """Expected points of the best missile that chariot c could launch from a cell, guided by its soldier."""
    best = 0.0
    if row == SPENT:
        return best
    for s in piece_range(first_piece(camp, game), end_piece(camp, game)):
        soldier = pieces[s]
        if soldier.home != c or not on_map(soldier) or soldier.sees == 0:
            continue
        for n in range(brain.n_foes):
            j = brain.foes[n]
            if not sees_itself(soldier, pieces[j]) or target_class(pieces[j].kind) != TargetClass.VEHICLE:
                continue
            known = memory[camp, j]
            shelter = int(cells[known.cell].concealed) + int(known.hidden)
            value = danger_of(row, cell, pieces[j].kind, known.cell, shelter, cells, atlas)
            best = max(best, brain.trust[j] * value)
    return best


@kernel
def weight_of(piece_kind: int, blood: int, rules: RulesRecord) -> float:
    """Fighting power of a piece: its value in points."""
    return float(rules.value[piece_kind]) * blood


@kernel
def own_power(
    cell: CellIndex,
    within: int,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
) -> float:
    """Power of own pieces within some cells of a cell, passengers included."""
    total = 0.0
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if pieces[i].blood > 0 and cells_apart(cells, pieces[i].cell, cell) <= within:
            total += weight_of(pieces[i].kind, pieces[i].blood, rules)
    return total


@kernel
def known_power(
    cell: CellIndex, within: int, camp: CampIndex, pieces: Pieces, memory: Memory, brain: BrainRecord, rules: RulesRecord, cells: Cells,
) -> float:  # fmt: skip
    """Power of known enemies within some cells of a cell, weighted by trust."""
    total = 0.0
    for n in range(brain.n_foes):
        j = brain.foes[n]
        known = memory[camp, j]
        if cells_apart(cells, known.cell, cell) <= within:
            total += brain.trust[j] * weight_of(pieces[j].kind, known.blood, rules)
    return total


@kernel
def known_lead(camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rules: RulesRecord) -> int:
    """Own total minus the enemy's as the camp knows it: what decides the game."""
    lead = known_margin(game, pieces, memory, camp, rules)
    return int(lead if game.net_score else lead + points_value(game, Camp.GREEN))


@kernel
def enemy_near(
    cell: CellIndex,
    within: int,
    camp: CampIndex,
    pieces: Pieces,
    memory: Memory,
    brain: BrainRecord,
    cells: Cells,
) -> bool:
    """A known enemy ground piece is within some cells of a cell."""
    for n in range(brain.n_foes):
        j = brain.foes[n]
        if pieces[j].kind != PieceType.AEROCRAFT and cells_apart(cells, memory[camp, j].cell, cell) <= within:
            return True
    return False
