"""When a task is over: done, or no longer possible."""

from __future__ import annotations

from hexwar_sb3.engine.pieces import has_path, on_map, weapon_ammo
from hexwar_sb3.engine.records import NO_PIECE, GameRecord, Memory, PieceRecord, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Weapon
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.tasks.known import can_hurt, is_known
from hexwar_sb3.tasks.records import ENDED, PlanRecord, Plans, TaskKind
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
def can_end(piece: PieceRecord, plan: PlanRecord) -> bool:
    """Holding and hiding never end while the piece is on the map."""
    if plan.state == ENDED:
        return False
    return not on_map(piece) or (plan.kind != TaskKind.HOLD and plan.kind != TaskKind.HIDE)


@kernel
def is_over(
    i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, plans: Plans, rules: RulesRecord
) -> bool:
    """The task is done, or has become impossible."""
    piece = pieces[i]
    plan = plans[i]
    if not on_map(piece):
        return True
    if is_at_target(plan.kind) and not is_known(memory[piece.camp, plan.target]):
        return True
    if plan.kind == TaskKind.ATTACK:
        return not can_hurt(piece, pieces[plan.target].kind, rules)
    if plan.kind == TaskKind.GUIDE:
        return not has_launcher(i, game, pieces, rules)
    if plan.kind == TaskKind.BOMBARD:
        return weapon_ammo(piece, Weapon.MORTAR, rules) == 0
    if plan.kind == TaskKind.BOARD:
        carrier = pieces[plan.target]
        return carrier.blood == 0 or carrier.passenger != NO_PIECE
    if plan.kind == TaskKind.DROP:
        return piece.passenger == NO_PIECE
    if plan.kind == TaskKind.RECOVER:
        return not piece.suppressed
    return plan.kind == TaskKind.STOP and not has_path(piece)


@kernel
def end_task(
    i: PieceIndex, game: GameRecord, pieces: Pieces, memory: Memory, plans: Plans, rules: RulesRecord
) -> None:
    """Mark a task that is over; the piece then stays where it is."""
    if is_over(i, game, pieces, memory, plans, rules):
        plans[i].state = ENDED
        plans[i].direction = 0
