"""The random player: at every thought each piece tries random orders until one is legal."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.dice import splitmix64
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.pieces import hop_from, on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import frame_direction
from hexwar_sb3.rules.enums import Action, Weapon
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import TaskKind

_ACTIONS, _WEAPONS = len(Action), len(Weapon)
_S32 = np.uint64(32)


@kernel
def draw(count: int, camp: int, game: Row, brain: Row) -> int:
    """Next random number 0..count - 1 of a camp: a hash of the game's seed, its salt and a counter."""
    brain.draws += 1
    key = splitmix64(game.salt[camp] ^ np.uint64(brain.draws))
    high = splitmix64(game.seed ^ key) >> _S32
    return int(np.int64((high * np.uint64(count)) >> _S32))


@kernel
def act_at_random(
    camp: int, game: Row, pieces: Rows, orders: Rows, plans: Rows, brain: Row, rules: Row, cells: Rows,
    config: Row,
) -> None:  # fmt: skip
    """Give every piece a random legal order, if one is found in a few tries."""
    for i in range(first_piece(camp, game), end_piece(camp, game)):
        if not on_map(pieces[i]):
            continue
        assign(plans[i], TaskKind.HOLD, NO_PIECE, NO_CELL, game.tick)  # an inert task: nothing of its own
        plans[i].hold_fire = 1
        for _ in range(config.random_tries):
            fill_order(i, camp, game, pieces, orders, brain, rules, cells, config)
            if order_code(i, orders[i], game, pieces, rules, cells) == Code.OK:
                break
            orders[i].kind = Action.NULL


@kernel
def fill_order(
    i: int, camp: int, game: Row, pieces: Rows, orders: Rows, brain: Row, rules: Row, cells: Rows, config: Row
) -> None:
    """One order drawn at random, legal or not."""
    order = orders[i]
    order.kind = draw(_ACTIONS, camp, game, brain)
    order.weapon = draw(_WEAPONS, camp, game, brain)
    order.target = draw(game.n_pieces, camp, game, brain)
    order.partner = draw(game.n_pieces, camp, game, brain)
    order.cell = draw(cells.size, camp, game, brain)
    order.path_len = 0
    if order.kind == Action.MOVE:
        wander(
            i, 1 + draw(config.random_hops, camp, game, brain), camp, game, pieces, orders, brain, rules,
            cells,
        )  # fmt: skip
    elif order.kind == Action.GET_OFF:
        order.target = pieces[i].passenger


@kernel
def wander(
    i: int, hops: int, camp: int, game: Row, pieces: Rows, orders: Rows, brain: Row, rules: Row, cells: Rows
) -> None:
    """A random path of at most so many hops."""
    order = orders[i]
    cell = int(pieces[i].cell)
    for _ in range(hops):
        d = frame_direction(draw(6, camp, game, brain), camp)
        if hop_from(pieces[i].kind, cell, d, rules, cells) == 0:
            return
        order.path[order.path_len] = d
        order.path_len += 1
        cell = int(cells[cell].neighbour[d])
