"""Chances of every result of a shot: the tables of section 7 with all dice counted out.

They are derived from the other fields of the record and so no part of the rules' hash.
`odds_vehicle[armour, blood, level, modifiers - LEAST_MODIFIER, result - LEAST_RESULT]` and its like
sum to 1 over the results; entries that the rule book does not have (level 0, blood 0) are 0.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexwar_sb3.rules.compiled import LEAST_MODIFIER, LEAST_RESULT, MOST_MODIFIER, MOST_RESULT

Chances = npt.NDArray[np.float64]

SIDES = 6  # of a die
ONE_DIE = dict.fromkeys(range(1, SIDES + 1), 1 / SIDES)
TWO_DICE = {roll: (SIDES - abs(roll - SIDES - 1)) / SIDES**2 for roll in range(2, 2 * SIDES + 1)}
MODIFIERS = np.arange(LEAST_MODIFIER, MOST_MODIFIER + 1)
RESULTS = np.arange(LEAST_RESULT, MOST_RESULT + 1)
CORRECTIONS = np.arange(-3, 4)  # what a correction table may hold
LEAST_CORRECTED_ROLL = -3  # the first row of `vehicle_correction`, as compiled.py says


def fill_odds(record: np.record) -> None:
    """Write the four odds tables into a record whose other tables are filled."""
    column, level = _results(record.vehicle_result), _results(record.soldier_result)
    vehicle, soldier = _vehicle_corrections(record), _soldier_corrections(record)
    record.odds_vehicle[:, 1:, 1:] = _combined(column[record.column[1:, 1:]], vehicle)
    record.odds_small[:, 1:] = _combined(level[1:], vehicle)
    record.odds_soldier[1:] = _combined(level[1:], soldier)[0]
    levels = np.arange(record.odds_air.size)
    record.odds_air[:] = sum(
        chance * (levels >= record.air_kill_level[roll]) for roll, chance in TWO_DICE.items()
    )


def _results(table: npt.NDArray[np.int8]) -> Chances:
    """[column, result] from a table [two dice, column]."""
    chances = np.zeros((table.shape[1], RESULTS.size))
    for roll, chance in TWO_DICE.items():
        chances += chance * (table[roll][:, None] == RESULTS)
    return chances


def _vehicle_corrections(record: np.record) -> Chances:
    """[armour, modifiers, correction]."""
    table = record.vehicle_correction
    chances = np.zeros((table.shape[1], MODIFIERS.size, CORRECTIONS.size))
    for roll, chance in TWO_DICE.items():
        rows = np.clip(roll + MODIFIERS - LEAST_CORRECTED_ROLL, 0, len(table) - 1)
        chances += chance * (table[rows].T[:, :, None] == CORRECTIONS)
    return chances


def _soldier_corrections(record: np.record) -> Chances:
    """[1, modifiers, correction]."""
    table = record.soldier_correction
    chances = np.zeros((1, MODIFIERS.size, CORRECTIONS.size))
    for roll, chance in ONE_DIE.items():
        rows = np.clip(roll + MODIFIERS, 0, len(table) - 1)
        chances += chance * (table[rows][:, None] == CORRECTIONS)
    return chances


def _combined(raw: Chances, corrections: Chances) -> Chances:
    """[armour, ..., modifiers, result] from raw results [..., result] and corrections."""
    shape = (len(corrections), *raw.shape[:-1], MODIFIERS.size, RESULTS.size)
    chances = np.zeros(shape)
    for i, result in enumerate(RESULTS):
        for j, correction in enumerate(CORRECTIONS):
            final = np.clip(result + correction, LEAST_RESULT, MOST_RESULT) - LEAST_RESULT
            correct = corrections[..., j].reshape(len(corrections), *[1] * (raw.ndim - 1), -1)
            chances[..., final] += raw[..., i, None] * correct
    return chances
