"""Missions in a player's fire style, for the shared executor."""

from __future__ import annotations

from hexwar_sb3.bots.config import Style
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.records import Missions, TaskKind


@kernel
def give_mission(
    style: Style, i: PieceIndex, kind: int, cell: CellIndex, game: GameRecord, missions: Missions
) -> None:
    """Give piece i a task at a cell, in the player's fire style."""
    assign(missions[i], kind, NO_PIECE, cell, game.tick)
    set_style(style, i, kind, missions)


@kernel
def attack(
    style: Style, i: PieceIndex, kind: int, target: PieceIndex, game: GameRecord, missions: Missions
) -> None:
    """Give piece i a task at an enemy."""
    assign(missions[i], kind, target, NO_CELL, game.tick)
    set_style(style, i, kind, missions)


@kernel
def board(style: Style, i: PieceIndex, chariot: PieceIndex, game: GameRecord, missions: Missions) -> None:
    """Let soldier i board a chariot."""
    assign(missions[i], TaskKind.BOARD, chariot, NO_CELL, game.tick)
    set_style(style, i, TaskKind.BOARD, missions)


@kernel
def set_style(style: Style, i: PieceIndex, kind: int, missions: Missions) -> None:
    """The player's fire style for a task."""
    mission = missions[i]
    mission.covered = style.covered
    mission.fire_value = style.ambush_value if kind == TaskKind.HIDE else style.fire_value
    mission.stop_value = style.stop_value
