"""The random player: at every thought each piece tries random orders until one is legal."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import BotConfig
from hexwar_sb3.bots.records import BrainRecord
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.dice import splitmix64
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.pieces import hop_from, on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Orders, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import frame_direction
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range
from hexwar_sb3.tasks.choose import assign
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import Missions, TaskKind

_ACTIONS, _WEAPONS = len(Action), len(Weapon)
_S32 = np.uint64(32)


@kernel
def draw(count: int, camp: CampIndex, game: GameRecord, brain: BrainRecord) -> int:
    """Next random number 0..count - 1 of a camp: a hash of the game's seed, its salt and a counter."""
    brain.draws += 1
    key = splitmix64(game.salt[camp] ^ np.uint64(brain.draws))
    high = splitmix64(game.seed ^ key) >> _S32
    return int(np.int64((high * np.uint64(count)) >> _S32))


@kernel
def act_at_random(
    camp: CampIndex, game: GameRecord, pieces: Pieces, orders: Orders, missions: Missions, brain: BrainRecord, rules: RulesRecord, cells: Cells,
    config: BotConfig,
) -> None:  # fmt: skip
    """Give every piece a random legal order, if one is found in a few tries."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if not on_map(pieces[i]):
            continue
        assign(missions[i], TaskKind.HOLD, NO_PIECE, NO_CELL, game.tick)  # an inert task: nothing of its own
        missions[i].hold_fire = 1
        for _ in range(config.random_tries):
            fill_order(i, camp, game, pieces, orders, brain, rules, cells, config)
            if order_code(i, orders[i], game, pieces, rules, cells) == Code.OK:
                break
            orders[i].kind = Action.NULL


@kernel
def fill_order(
    i: PieceIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    brain: BrainRecord,
    rules: RulesRecord,
    cells: Cells,
    config: BotConfig,
) -> None:
    """One order drawn at random, legal or not."""
    order = orders[i]
    order.kind = draw(_ACTIONS, camp, game, brain)
    order.weapon = draw(_WEAPONS, camp, game, brain)
    order.target = PieceIndex(draw(game.n_pieces, camp, game, brain))
    order.partner = PieceIndex(draw(game.n_pieces, camp, game, brain))
    order.cell = CellIndex(draw(cells.size, camp, game, brain))
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
    i: PieceIndex,
    hops: int,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    orders: Orders,
    brain: BrainRecord,
    rules: RulesRecord,
    cells: Cells,
) -> None:
    """A random path of at most so many hops."""
    order = orders[i]
    cell = CellIndex(pieces[i].cell)
    for _ in range(hops):
        d = frame_direction(draw(6, camp, game, brain), camp)
        if hop_from(pieces[i].kind, cell, d, rules, cells) == 0:
            return
        order.path[order.path_len] = d
        order.path_len += 1
        cell = CellIndex(cells[cell].neighbour[d])
