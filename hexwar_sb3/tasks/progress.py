"""When a task is over: done, or no longer possible."""

from __future__ import annotations

from hexwar_sb3.engine.pieces import has_path, on_map, weapon_ammo
from hexwar_sb3.engine.records import NO_PIECE, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Weapon
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.tasks.known import can_hurt, is_known
from hexwar_sb3.tasks.records import ENDED, MissionRecord, Missions, TaskKind
from hexwar_sb3.tasks.sets import has_launcher


@kernel
def is_at_target(kind: int) -> bool:
    """Kinds whose target is an enemy."""
    return (
        kind == TaskKind.ATTACK
        or kind == TaskKind.GUIDE
        or kind == TaskKind.BOMBARD
        or kind == TaskKind.SHADOW
    )


@kernel
def can_end(piece: PieceRecord, mission: MissionRecord) -> bool:
    """Holding and hiding never end while the piece is on the map."""
    if mission.state == ENDED:
        return False
    return not on_map(piece) or (mission.kind != TaskKind.HOLD and mission.kind != TaskKind.HIDE)


@kernel
def is_over(
    i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord
) -> bool:
    """The task is done, or has become impossible."""
    piece = pieces[i]
    mission = missions[i]
    if not on_map(piece):
        return True
    if is_at_target(mission.kind) and not is_known(memory[piece.camp, mission.target]):
        return True
    if mission.kind == TaskKind.ATTACK:
        return not can_hurt(piece, pieces[mission.target].kind, rules)
    if mission.kind == TaskKind.GUIDE:
        return not has_launcher(i, game, pieces, rules)
    if mission.kind == TaskKind.BOMBARD:
        return weapon_ammo(piece, Weapon.MORTAR, rules) == 0
    if mission.kind == TaskKind.BOARD:
        carrier = pieces[mission.target]
        return carrier.blood == 0 or carrier.passenger != NO_PIECE
    if mission.kind == TaskKind.DROP:
        return piece.passenger == NO_PIECE
    if mission.kind == TaskKind.RECOVER:
        return not piece.suppressed
    return mission.kind == TaskKind.STOP and not has_path(piece)


@kernel
def end_task(
    i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, rules: RulesRecord
) -> None:
    """Mark a task that is over; the piece then stays where it is."""
    if is_over(i, game, pieces, memory, missions, rules):
        missions[i].state = ENDED
        missions[i].direction = 0
