"""Who works for which control point: takers of foreign points, keepers of own ones."""

from __future__ import annotations

from hexwar_sb3.bots.records import NOBODY
from hexwar_sb3.bots.weigh import enemy_near, known_power, own_power
from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.travel import UNREACHABLE, travel_ticks


@kernel
def first_points(camp: int, game: Row, pieces: Rows, brain: Row, atlas: Row) -> None:
    """Deal the pieces of each type out to the points, the most valuable point first; soldiers follow their chariot."""
    first = first_piece(camp, game)
    for i in range(first, end_piece(camp, game)):
        same = 0
        for other in range(first, i):
            if pieces[other].kind == pieces[i].kind:
                same += 1
        brain.point[i - first] = atlas.rank[same % max(1, game.n_points)]
        brain.post[i - first] = -1
    for i in range(first, end_piece(camp, game)):
        if pieces[i].home >= 0:
            brain.point[i - first] = brain.point[pieces[i].home - first]


@kernel
def is_safe(
    k: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, cells: Rows, config: Row
) -> bool:
    """An own point with no known enemy around."""
    if game.point_owner[k] != camp:
        return False
    return not enemy_near(game.point_cell[k], config.safe_point_cells, camp, pieces, memory, brain, cells)


@kernel
def move_idle(
    camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, cells: Rows, config: Row, atlas: Row
) -> None:
    """Pieces of a safe point, its keeper left out, go to work for the best point that is not safe."""
    for n in range(game.n_points):
        k = atlas.rank[n]
        if is_safe(k, camp, game, pieces, memory, brain, cells, config):
            continue
        for slot in range(end_piece(camp, game) - first_piece(camp, game)):
            now = brain.point[slot]
            if (
                now != k
                and brain.keeper[now] != slot
                and is_safe(now, camp, game, pieces, memory, brain, cells, config)
            ):
                brain.point[slot] = k
        return


@kernel
def choose_people(
    style: Row, camp: int, game: Row, pieces: Rows, brain: Row, rules: Row, cells: Rows, eta: Rows,
    config: Row,
) -> None:  # fmt: skip
    """Name the taker of every foreign point and the keeper of every own one."""
    for k in range(game.n_points):
        brain.taker[k], brain.keeper[k] = NOBODY, NOBODY
        if game.point_owner[k] == camp:
            brain.keeper[k] = best_keeper(style, k, camp, game, pieces, rules, cells, config)
        else:
            brain.taker[k] = best_taker(style, k, camp, game, pieces, brain, rules, cells, eta)


@kernel
def best_keeper(
    style: Row, k: int, camp: int, game: Row, pieces: Rows, rules: Row, cells: Rows, config: Row
) -> int:
    """Slot of the ground piece of least value that is at an own point, soldiers first; NOBODY."""
    best, least = NOBODY, 0
    first = first_piece(camp, game)
    for i in range(first, end_piece(camp, game)):
        piece = pieces[i]
        if not on_map(piece) or piece.kind == PieceType.AEROCRAFT or piece.passenger >= 0:
            continue
        if piece.kind != PieceType.SOLDIER and not style.keep_vehicles:
            continue
        if cells_apart(cells, piece.cell, game.point_cell[k]) > config.keeper_cells:
            continue
        value = int(rules.value[piece.kind]) * piece.blood
        if piece.kind == PieceType.SOLDIER:
            value = 0
        if best == NOBODY or value < least:
            best, least = i - first, value
    return best


@kernel
def best_taker(
    style: Row, k: int, camp: int, game: Row, pieces: Rows, brain: Row, rules: Row, cells: Rows, eta: Rows
) -> int:
    """Slot of the piece that takes a foreign point: the quickest, by the style's delays; NOBODY."""
    best, least = NOBODY, float(UNREACHABLE)
    first = first_piece(camp, game)
    for i in range(first, end_piece(camp, game)):
        piece = pieces[i]
        if not on_map(piece) or piece.kind == PieceType.AEROCRAFT or brain.point[i - first] != k:
            continue
        ticks = travel_ticks(piece.kind, piece.cell, game.point_cell[k], rules, cells, eta)
        cost = ticks + style.take_delay[piece.kind]
        if piece.passenger != NO_PIECE:
            cost += style.carry_delay
        if piece.kind == PieceType.SOLDIER and ticks > style.walk_ticks:
            continue
        if cost < least and ticks < game.end_tick - game.tick:
            best, least = i - first, cost
    return best


@kernel
def may_enter(
    style: Row, k: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, rules: Row,
    cells: Rows,
) -> bool:  # fmt: skip
    """The camp is strong enough around a foreign point to go in, or it is time to."""
    if brain.rush:
        return True
    cell = game.point_cell[k]
    enemies = known_power(cell, style.around_cells, camp, pieces, memory, brain, rules, cells)
    if enemies <= 0.0:
        return True
    own = own_power(cell, style.own_cells, camp, game, pieces, rules, cells)
    return own >= style.enter_ratio * enemies
