"""A mirrored game is played in the mirrored way: same sets, same rows, mirrored orders (architecture.md, section 3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.maps.geometry import MIRROR_DIRECTION
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import CampIndex
from hexwar_sb3.tasks.features import feature_index

if TYPE_CHECKING:
    from tests.tasks.conftest import Board, Choose

N = 7
SWAPPED = [*range(N, 2 * N), *range(N)]
TURN = np.array(MIRROR_DIRECTION)


def mirror(board: Board) -> None:
    """Swap the colours and mirror the map, dice salts included, in place."""
    state = board.state
    for name in ("pieces", "memory", "paths", "orders"):
        rows = getattr(state, name)
        rows[:] = (rows[:, ::-1] if name == "memory" else rows)[
            ..., SWAPPED, *[slice(None)] * (name == "paths")
        ]
    board.missions[:] = board.missions[SWAPPED]
    state.paths[:] = TURN[np.minimum(state.paths, 5)]
    state.pieces.camp[:] = 1 - state.pieces.camp
    for link in ("home", "carrier", "passenger", "board_partner"):
        swap_index(state.pieces[link])
    swap_index(board.missions["target"])
    for rows, fields in (
        (state.pieces, ("cell",)),
        (state.memory, ("cell", "next_cell")),
        (board.missions, ("cell", "goal")),
        (state.games, ("point_cell", "fight_cell")),
        (state.rounds, ("cell", "impact")),
    ):
        for field in fields:
            mirror_cells(board, rows[field])
    mirror_game(board.game, state.rounds)


def swap_index(values: Any) -> None:
    values[:] = np.where(values == NO_PIECE, NO_PIECE, (values + N) % (2 * N))


def mirror_cells(board: Board, values: Any) -> None:
    values[:] = np.where(values == NO_CELL, NO_CELL, board.cells.mirror[values])


def mirror_game(game: Any, rounds: Any) -> None:
    owner = game.point_owner
    owner[:] = np.where(owner == Camp.GREEN, owner, 1 - owner)
    game.salt[:] = game.salt[::-1].copy()
    for pair in (game.loss_tick, game.contact_tick):
        pair[:] = pair[::-1].copy()
    rounds[:] = np.roll(rounds, rounds.shape[1] // 2, axis=1)  # red's chariots come first
    swap_index(rounds["owner"])
    rounds.camp[:] = 1 - rounds.camp
    rounds.judged[:] = rounds.judged[..., ::-1].copy()


def test_a_mirrored_position_has_the_same_sets_and_observations(middle: Callable[[int], Board]) -> None:
    """All but the bit that tells the colour."""
    blue_bit = feature_index("obs", N, N, 2)["game: blue"]
    for seed in range(8):
        board = middle(seed)
        before = [board.observation(camp) for camp in (Camp.RED, Camp.BLUE)]
        mirror(board)
        after = [board.observation(camp) for camp in (Camp.BLUE, Camp.RED)]
        for one, other in zip(before, after, strict=True):
            one["obs"][:, blue_bit] = other["obs"][:, blue_bit] = 0.0
            for key in ("mask", "rows", "obs", "alive"):
                assert one[key].tobytes() == other[key].tobytes(), key
            assert one["tasks"]["kind"].tobytes() == other["tasks"]["kind"].tobytes()


def orders_of(board: Board) -> list[tuple[int, ...]]:
    """What everybody is ordered now, in the frame of red."""
    board.execute(Camp.RED)
    board.execute(Camp.BLUE)
    rows = board.orders
    return [(int(row.kind), int(row.target) % N, int(row.weapon), int(row.path[0])) for row in rows]


def test_a_mirrored_position_gets_the_mirrored_orders(
    middle: Callable[[int], Board], sticky: Callable[[int], Choose]
) -> None:
    moves = 0
    for seed in range(8):
        plain, turned = middle(seed), middle(seed)
        for camp in (Camp.RED, Camp.BLUE):
            plain.decide(camp, sticky(seed + 1))
            turned.decide(camp, sticky(seed + 1))
        mirror(turned)
        orders, mirrored = orders_of(plain), orders_of(turned)
        for i, (kind, target, weapon, direction) in enumerate(orders):
            other = mirrored[SWAPPED[i]]
            assert other[0] == kind
            if kind == Action.MOVE:
                assert other[3] == MIRROR_DIRECTION[direction]
                moves += 1
            elif kind == Action.SHOOT:
                assert other[1:3] == (target, weapon)
    assert moves > 0


def test_a_mirrored_game_ends_as_the_mirrored_game(
    board: Board, world: Any, sticky: Callable[[int], Choose]
) -> None:
    """Same seed, salts swapped, choosers swapped: no order depends on the colour."""
    turned = type(board)(world)
    mirror(turned)
    choose = sticky(5)

    def swapped(other: Board, camp: int, tasks: Any, mask: Any) -> Any:
        return choose(other, CampIndex(1 - camp), tasks, mask)

    board.play(1800, choose)
    turned.play(1800, swapped)
    mirror(turned)

    assert board.pieces.blood.tolist() == turned.pieces.blood.tolist()
    assert board.pieces.cell.tolist() == turned.pieces.cell.tolist()
    assert board.game.point_owner.tolist() == turned.game.point_owner.tolist()
    assert board.pieces.blood.sum() < 38  # something happened
