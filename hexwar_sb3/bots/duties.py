"""What each piece of the two full players does next: plans for the shared executor (bots.md)."""

from __future__ import annotations

from hexwar_sb3.bots.points import may_enter
from hexwar_sb3.bots.posts import choose_post, hunting_post
from hexwar_sb3.bots.records import NOBODY
from hexwar_sb3.bots.scout import scout
from hexwar_sb3.bots.weigh import enemy_near, threat_at
from hexwar_sb3.engine.pieces import in_fight
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.known import end_piece, first_piece, ticks_left
from hexwar_sb3.tasks.phi import has_flying_round
from hexwar_sb3.tasks.records import TaskKind
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks


@kernel
def give_plan(style: Row, i: int, kind: int, cell: int, game: Row, plans: Rows) -> None:
    """Give piece i a task at a cell, in the player's fire style."""
    assign(plans[i], kind, NO_PIECE, cell, game.tick)
    set_style(style, i, kind, plans)


@kernel
def set_style(style: Row, i: int, kind: int, plans: Rows) -> None:
    """The player's fire style for a task."""
    plan = plans[i]
    plan.covered = style.covered
    plan.fire_value = style.ambush_value if kind == TaskKind.HIDE else style.fire_value
    plan.stop_value = style.stop_value


@kernel
def order_duties(
    style: Row, camp: int, game: Row, pieces: Rows, memory: Rows, rounds: Rows, plans: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Give every piece of the camp that is on the map its plan."""
    first = first_piece(camp, game)
    for i in range(first, end_piece(camp, game)):
        piece = pieces[i]
        if piece.blood == 0 or piece.carrier != NO_PIECE or in_fight(game, piece):
            continue
        if piece.kind == PieceType.AEROCRAFT:
            cell = scout(style, i, camp, game, pieces, memory, brain, rules, cells, los, atlas)
            give_plan(style, i, TaskKind.HOLD, cell, game, plans)
        elif recovers(i, camp, game, pieces, memory, brain, rules, cells):
            give_plan(style, i, TaskKind.RECOVER, NO_CELL, game, plans)
        elif has_flying_round(i, rounds):
            stay(style, i, camp, game, pieces, brain, plans)
        elif not ride(style, i, camp, game, pieces, memory, plans, brain, rules, cells, los, eta, atlas):
            work(style, i, camp, game, pieces, memory, plans, brain, rules, cells, los, eta, atlas)


@kernel
def recovers(
    i: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, rules: Row, cells: Rows
) -> bool:
    """A suppressed soldier with time to gain and no enemy beside it works itself free."""
    piece = pieces[i]
    if piece.kind != PieceType.SOLDIER or not piece.suppressed:
        return False
    if ticks_left(piece.keep_ends, game.tick) <= rules.decompress_above_ticks:
        return False
    return not enemy_near(piece.cell, 2, camp, game, pieces, memory, brain, cells)


@kernel
def stay(style: Row, i: int, camp: int, game: Row, pieces: Rows, brain: Row, plans: Rows) -> None:
    """Stand where it is."""
    brain.post[i - first_piece(camp, game)] = pieces[i].cell
    give_plan(style, i, TaskKind.HOLD, pieces[i].cell, game, plans)


@kernel
def work(
    style: Row, i: int, camp: int, game: Row, pieces: Rows, memory: Rows, plans: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Take a point, keep one, carry a soldier, or fire from the best post."""
    slot = i - first_piece(camp, game)
    k = brain.point[slot]
    if pieces[i].passenger != NO_PIECE:
        carry(style, i, k, camp, game, pieces, memory, plans, brain, rules, cells, los, eta, atlas)
        return
    for p in range(game.n_points):
        if brain.keeper[p] == slot:
            brain.post[slot] = NO_CELL
            give_plan(style, i, TaskKind.HIDE, game.point_cell[p], game, plans)
            return
        if brain.taker[p] == slot and may_enter(
            style, p, camp, game, pieces, memory, brain, rules, cells, atlas.config
        ):
            brain.post[slot] = NO_CELL
            give_plan(style, i, TaskKind.HOLD, game.point_cell[p], game, plans)
            return
    if pieces[i].kind == PieceType.SOLDIER:
        give_plan(style, i, TaskKind.HIDE, pieces[i].cell, game, plans)
        return
    take_post(style, i, camp, game, pieces, memory, plans, brain, rules, cells, los, eta, atlas)


@kernel
def take_post(
    style: Row, i: int, camp: int, game: Row, pieces: Rows, memory: Rows, plans: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Go to the best post and fire from it; hide there while nobody is in sight."""
    slot = i - first_piece(camp, game)
    prey = (
        best_prey(i, camp, game, pieces, memory, brain, rules, cells, eta, atlas) if style.hunt else NO_PIECE
    )
    if prey != NO_PIECE:
        cell = hunting_post(style, i, prey, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas)
    else:
        cell = choose_post(style, i, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas)
    brain.post[slot] = cell
    hides = pieces[i].sees == 0 or style.always_hide
    give_plan(style, i, TaskKind.HIDE if hides else TaskKind.HOLD, cell, game, plans)


@kernel
def best_prey(
    i: int,
    camp: int,
    game: Row,
    pieces: Rows,
    memory: Rows,
    brain: Row,
    rules: Row,
    cells: Rows,
    eta: Rows,
    atlas: Row,
) -> int:
    """Known enemy that is worth most for the way to it; NO_PIECE."""
    best, prey = 0.0, NO_PIECE
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        if brain.trust[j] <= 0.0 or pieces[j].kind == PieceType.AEROCRAFT:
            continue
        ticks = travel_ticks(pieces[i].kind, pieces[i].cell, memory[camp, j].cell, rules, cells, eta)
        if ticks >= UNREACHABLE:
            continue
        value = brain.trust[j] * rules.value[pieces[j].kind] / (1.0 + ticks / atlas.config.hunt_ticks)
        if value > best:
            best, prey = value, j
    return prey


@kernel
def carry(
    style: Row, i: int, k: int, camp: int, game: Row, pieces: Rows, memory: Rows, plans: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Bring the soldier to its point: take the point on the way if that is possible."""
    slot = i - first_piece(camp, game)
    point = game.point_cell[k]
    brain.post[slot] = NO_CELL
    quiet = not enemy_near(point, style.drop_cells, camp, game, pieces, memory, brain, cells)
    if (
        brain.taker[k] == slot
        and quiet
        and may_enter(style, k, camp, game, pieces, memory, brain, rules, cells, atlas.config)
    ):
        give_plan(style, i, TaskKind.HOLD, point, game, plans)
    elif game.point_owner[k] == camp and quiet:
        give_plan(style, i, TaskKind.DROP, point, game, plans)
    else:
        cell = best_nest(style, i, k, camp, game, pieces, memory, brain, rules, cells, los, eta, atlas)
        give_plan(style, i, TaskKind.DROP, cell, game, plans)


@kernel
def best_nest(
    style: Row, i: int, k: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> int:  # fmt: skip
    """The nest of a point that is quickest to reach and least in danger."""
    best, best_score = int(pieces[i].cell), -1e9
    for n in range(atlas.nest.shape[2]):
        cell = int(atlas.nest[camp, k, n])
        if cell == NO_CELL:
            break
        ticks = travel_ticks(pieces[i].kind, pieces[i].cell, cell, rules, cells, eta)
        if ticks >= UNREACHABLE:
            continue
        score = -ticks / style.eta_ticks - style.threat_weight * threat_at(
            PieceType.CHARIOT, cell, camp, game, pieces, memory, brain, rules, cells, los, atlas
        )
        if score > best_score:
            best, best_score = cell, score
    return best


@kernel
def ride(
    style: Row, i: int, camp: int, game: Row, pieces: Rows, memory: Rows, plans: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> bool:  # fmt: skip
    """A soldier far from its work and its idle chariot meet where the soldier stands; False: no such business."""
    piece = pieces[i]
    if piece.kind == PieceType.SOLDIER:
        if not wants_ride(i, camp, game, pieces, brain, rules, cells, eta, atlas.config):
            return False
        chariot = pieces[piece.home]
        if chariot.cell == piece.cell:
            assign(plans[i], TaskKind.BOARD, piece.home, NO_CELL, game.tick)
            set_style(style, i, TaskKind.BOARD, plans)
        else:
            give_plan(style, i, TaskKind.HOLD, piece.cell, game, plans)
        return True
    if piece.kind != PieceType.CHARIOT or piece.passenger != NO_PIECE:
        return False
    for s in range(first_piece(camp, game), end_piece(camp, game)):
        if pieces[s].home == i and wants_ride(s, camp, game, pieces, brain, rules, cells, eta, atlas.config):
            brain.post[i - first_piece(camp, game)] = NO_CELL
            give_plan(style, i, TaskKind.HOLD, pieces[s].cell, game, plans)
            return True
    return False


@kernel
def wants_ride(
    s: int, camp: int, game: Row, pieces: Rows, brain: Row, rules: Row, cells: Rows, eta: Rows, config: Row
) -> bool:
    """Soldier s has work too far to walk to, no point to keep, and a free chariot near enough."""
    soldier = pieces[s]
    if (
        soldier.kind != PieceType.SOLDIER
        or soldier.blood == 0
        or soldier.carrier != NO_PIECE
        or soldier.suppressed
    ):
        return False
    slot = s - first_piece(camp, game)
    for k in range(game.n_points):
        if brain.keeper[k] == slot or brain.taker[k] == slot:
            return False
    work_cell = game.point_cell[brain.point[slot]]
    if cells_apart(cells, soldier.cell, work_cell) <= config.walk_cells:
        return False
    chariot = pieces[soldier.home]
    if chariot.blood == 0 or chariot.passenger != NO_PIECE or chariot.suppressed:
        return False
    ticks = travel_ticks(PieceType.CHARIOT, chariot.cell, soldier.cell, rules, cells, eta)
    ticks += travel_ticks(PieceType.CHARIOT, soldier.cell, work_cell, rules, cells, eta)
    return ticks + config.ride_spare_ticks < game.end_tick - game.tick
