"""Write a rule set into the record that kernels read (compiled.py)."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.rows import RuleTables, Table

GROUND = (PieceType.TANK, PieceType.CHARIOT, PieceType.SOLDIER)
VEHICLES = (PieceType.TANK, PieceType.CHARIOT)


def fill_record(record: np.record, rules: RuleTables) -> None:
    """Write everything but the odds, in place."""
    _fill_pieces(record, rules)
    _fill_sight(record, rules)
    _fill_levels(record, rules)
    for number in rules.numbers:
        record[number.name] = number.value
    for table in rules.tables:
        _fill_table(record, table)


def _fill_pieces(record: np.record, rules: RuleTables) -> None:
    record.pool[:] = NO_POOL
    for row in rules.pieces:
        record.value[row.kind] = row.value
        record.blood[row.kind] = row.blood
        record.armour[row.kind] = row.armour
        record.base_hop[row.kind] = row.base_hop
        record.moving_fire[row.kind] = row.moving_fire
        for index, pool in enumerate(row.pools):
            record.pool_ammo[row.kind, index] = pool.ammo
            record.pool[row.kind, list(pool.weapons)] = index


def _fill_sight(record: np.record, rules: RuleTables) -> None:
    ground, air = rules.ground_sight, rules.aerocraft
    record.sight[GROUND, PieceType.SOLDIER] = ground.soldier_cells
    record.sight[PieceType.AEROCRAFT, PieceType.SOLDIER] = air.soldier_cells
    for vehicle in VEHICLES:
        record.sight[GROUND, vehicle] = ground.vehicle_cells
        record.sight[PieceType.AEROCRAFT, vehicle] = air.vehicle_cells
    record.sight[:, PieceType.AEROCRAFT] = air.seen_cells


def _fill_levels(record: np.record, rules: RuleTables) -> None:
    for row in rules.attacks:
        for blood in range(1, record.level.shape[2]):
            levels = row.of_blood(blood)
            columns = slice(row.first_cells, row.first_cells + len(levels))
            record.level[row.weapon, row.target, blood, columns] = levels


def _fill_table(record: np.record, table: Table) -> None:
    """A table that starts below 0 is moved up to 0, as compiled.py says."""
    cells = np.array(table.cells)
    starts = [max(first, 0) for first in table.first]
    place = tuple(slice(at, at + size) for at, size in zip(starts, cells.shape, strict=True))
    record[table.name][place] = cells
