"""Whole games as committed text: any change of a rule or of the dice shows as a diff.

`python tests/engine/test_playthroughs.py` writes them anew; review what changed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.order_rows import read_order
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import PieceIndex
from tests.engine.random_orders import random_orders

FOLDER = Path(__file__).parent / "playthroughs"
BOARD = """
    map     plain-9x7
    point   main 0504 80
    cell    0403 0603 concealed
    cell    0405 0505 elev 40
    cell    0503 slushy
    red     tank 0103
    red     chariot 0104
    red     soldier 0203
    red     aerocraft 0102
    blue    tank 0903
    blue    chariot 0804
    blue    soldier 0803
    blue    aerocraft 0802
    ticks   900
"""
EVERY_TICKS = 9


def playthrough(seed: int) -> str:
    """A game of random legal orders: its orders and events, and the position every 150 ticks."""
    game = Game.from_text(BOARD, seed)
    lines = [str(game)]
    while not game.over:
        for camp, orders in random_batch(game, seed).items():
            game.submit(camp, orders)
            lines += [f"{camp}: {order}" for order in orders]
        lines += [str(event) for event in game.advance(EVERY_TICKS)]
        if game.tick % 150 < EVERY_TICKS:
            lines += ["", str(game), ""]
    return "\n".join([*lines, Replay.of(game).states[-1]["hash"], ""])


def random_batch(game: Game, seed: int) -> dict[str, list[Order]]:
    rows, tables = game.state.orders[0].copy(), game.world.tables[:2]
    random_orders(np.uint64(seed), game.state.games[0], game.pieces, rows, *tables)
    given = [i for i in range(rows.size) if rows[i].kind != Action.NULL]
    batch: dict[str, list[Order]] = {camp_name(camp): [] for camp in SIDES}
    for i in given:
        order = read_order(PieceIndex(i), rows[i], game.roster, game.pieces, game.world.cells)
        batch[camp_name(game.roster.camps[i])].append(order)
    return batch


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_committed_game_is_played_as_it_stands_in_its_file(seed: int) -> None:
    assert playthrough(seed) == (FOLDER / f"{seed}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for number in (1, 2, 3):
        (FOLDER / f"{number}.txt").write_text(playthrough(number), encoding="utf-8")
