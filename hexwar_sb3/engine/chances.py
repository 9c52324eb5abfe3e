"""Chances of a shot, by the camp's own knowledge (rule book, sections 7 and 9)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.fire import attack_level, shot_mods
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.mortar import observer_class
from hexwar_sb3.engine.orders import BurstChances, Chances
from hexwar_sb3.engine.pieces import target_class
from hexwar_sb3.engine.records import GameRecord, OrderRecord, Pieces
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines
from hexwar_sb3.rules.compiled import LEAST_MODIFIER, LEAST_RESULT, SCATTER_HIT, RulesRecord
from hexwar_sb3.rules.enums import TargetClass, Weapon
from hexwar_sb3.rules.indices import PieceIndex, cell_range
from hexwar_sb3.rules.odds import TWO_DICE

NOT_LEGAL = -1


def shot_chances(weapon: int, shooter: Row, target: Row, pieces: Rows, rules: Row, cells: Rows) -> Chances:
    """Chances of a direct or guided shot at the target's present blood.

    pieces: [P] as the camp knows them; an unseen enemy beside the target does not count.
    """
    level = int(attack_level(weapon, shooter, target, rules, cells))
    kind = target_class(target.kind)
    if kind == TargetClass.AEROCRAFT:
        destroyed = float(rules.odds_air[level])
        return Chances(level, 0, 1 - destroyed, 0.0, (destroyed,))
    mods = int(shot_mods(shooter, target, pieces, rules, cells))
    odds = _odds(weapon, kind, int(rules.armour[target.kind]), int(shooter.blood), level, rules)
    return _capped(level, mods, odds[mods - LEAST_MODIFIER], int(target.blood))


def _odds(weapon: int, kind: int, armour: int, blood: int, level: int, rules: Row) -> npt.NDArray[np.float32]:
    """Chances [modifiers, result] before the cap."""
    if kind == TargetClass.SOLDIER:
        return np.asarray(rules.odds_soldier[level])
    if weapon == Weapon.SMALL:
        return np.asarray(rules.odds_small[armour, level])
    return np.asarray(rules.odds_vehicle[armour, blood, level])


def _capped(level: int, mods: int, odds: npt.NDArray[np.float32], blood: int) -> Chances:
    """Results above the target's blood count as its last vehicle."""
    chances = [float(chance) for chance in odds]
    nothing, suppressed, *losses = chances[-1 - LEAST_RESULT :]
    return Chances(level, mods, nothing, suppressed, (*losses[: blood - 1], sum(losses[blood - 1 :])))


@kernel
def mortar_classes(
    i: PieceIndex,
    order: OrderRecord,
    game: GameRecord,
    pieces: Pieces,
    rules: RulesRecord,
    cells: Cells,
    los: Sightlines,
) -> Rows:
    """Correction class of a round of piece i at each cell as it is seen now [NC]; NOT_LEGAL elsewhere.

    order: an indirect-shoot order, whose cell is tried everywhere.
    """
    classes = np.full(cells.size, NOT_LEGAL, np.int8)
    for cell in cell_range(cells.size):
        order.cell = cell
        if order_code(i, order, game, pieces, rules, cells) == Code.OK:
            classes[cell] = observer_class(pieces[i].camp, cell, pieces, rules, cells, los)
    return classes


def burst_chances(correction_class: int, apart: int, rules: Row) -> BurstChances:
    """Where a round may come down, fired over this distance, by what is seen of the aimed cell."""
    column = (apart - 1) // int(rules.scatter_band_cells)
    scatter = rules.scatter[correction_class, :, column]
    hit = sum(chance for roll, chance in TWO_DICE.items() if scatter[roll] == SCATTER_HIT)
    off_target = sum(chance for roll, chance in TWO_DICE.items() if scatter[roll] == 0)
    return BurstChances(hit, off_target, 1 - hit - off_target)
