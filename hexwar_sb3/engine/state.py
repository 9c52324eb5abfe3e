"""The arrays of a batch of games, and how a game begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.dice import splitmix64
from hexwar_sb3.engine.records import (
    GAME,
    LOG,
    MEMORY,
    NEVER,
    NO_CELL,
    NO_PIECE,
    ORDER,
    PATH_CELLS,
    PIECE,
    ROUND,
    GameRecord,
)
from hexwar_sb3.engine.sight import look_all, remember
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.rules.enums import Camp, PieceType

ROUNDS_PER_CHARIOT = 2  # one may burst while the next one flies


@dataclass(slots=True)
class State:
    """Record arrays of B games; row b of each is game b."""

    games: Rows  # [B]
    pieces: Rows  # [B, P]
    memory: Rows  # [B, camp, P]
    paths: Rows  # directions [B, P, PATH_CELLS]
    rounds: Rows  # [B, R]
    orders: Rows  # [B, P]
    log: Rows  # [B, L]; L = 0: nothing is logged

    def game(self, b: int) -> tuple[Row | Rows, ...]:
        """Game b's rows, in the order in which kernels take them."""
        arrays = (self.games, self.pieces, self.memory, self.paths, self.rounds, self.orders, self.log)
        return tuple(
            np.ndarray.__getitem__(rows, b) for rows in arrays
        )  # a recarray's own takes ten times as long

    def copy_from(self, other: State, b: int, other_b: int) -> None:
        """Make game b equal to a game of another batch (the log excepted)."""
        for name in ("games", "pieces", "memory", "paths", "rounds", "orders"):
            getattr(self, name)[b] = getattr(other, name)[other_b]
        self.games[b].log_count = 0


def new_state(world: World, n_games: int, log_size: int = 0) -> State:
    """Room for n games, each at tick 0 with seed 0."""
    n, n_rounds = world.n_pieces, ROUNDS_PER_CHARIOT * len(_chariots(world))
    state = State(
        games=_rows((n_games,), GAME),
        pieces=_rows((n_games, n), PIECE),
        memory=_rows((n_games, 2, n), MEMORY),
        paths=np.zeros((n_games, n, PATH_CELLS), np.uint8),
        rounds=_rows((n_games, n_rounds), ROUND),
        orders=_rows((n_games, n), ORDER),
        log=_rows((n_games, log_size), LOG),
    )
    if n_games == 0:
        return state
    _set_up(state, world)
    for b in range(1, n_games):
        state.copy_from(state, b, 0)
    return state


def reset_game(state: State, b: int, world: World, seed: int) -> None:
    """Put game b back to tick 0 with a seed for its dice; of a larger one the last 64 bits count.

    Raises:
        ConfigError: the seed is no integer >= 0.
    """
    check_whole("seed", seed, least=0)
    state.copy_from(new_state(world, 1), b, 0)
    seed_game(state.games[b], np.uint64(seed & 0xFFFFFFFFFFFFFFFF))


@kernel
def seed_game(game: GameRecord, seed: np.uint64) -> None:
    """Set the seed and draw the two camps' salts from it."""
    game.seed = seed
    game.salt[Camp.RED] = splitmix64(seed ^ np.uint64(1))
    game.salt[Camp.BLUE] = splitmix64(seed ^ np.uint64(2))


def _rows(shape: tuple[int, ...], dtype: np.dtype[np.void]) -> Rows:
    return np.zeros(shape, dtype).view(np.recarray)


def _chariots(world: World) -> list[int]:
    return [i for i, piece in enumerate(world.scenario.pieces) if piece.kind == PieceType.CHARIOT]


def _set_up(state: State, world: World) -> None:
    """Write the start of the scenario into game 0 and take the first look."""
    game, pieces, memory, paths, rounds, _, _ = state.game(0)
    _set_up_game(game, world)
    for i in range(world.n_pieces):
        _set_up_piece(i, pieces, world)
    for k, owner in enumerate(np.repeat(_chariots(world), ROUNDS_PER_CHARIOT)):
        rounds[k].owner = owner
    memory.cell = NO_CELL
    memory.next_cell = NO_CELL
    rules, cells, los = world.tables
    look_all(pieces, rules, cells, los)
    remember(game, pieces, memory, paths, cells)


def _set_up_game(game: Row, world: World) -> None:
    scenario = world.scenario
    game.end_tick = scenario.game_ticks
    game.net_score = scenario.net_score
    game.fog = 1
    game.n_red = sum(piece.camp == Camp.RED for piece in scenario.pieces)
    game.n_pieces = world.n_pieces
    game.n_points = len(scenario.points)
    for k, point in enumerate(scenario.points):
        game.point_owner[k] = Camp.GREEN
        game.point_cell[k] = point.cell
        game.point_value[k] = point.value
    game.n_fights = 0
    game.fight_cell[:] = NO_CELL
    game.fight_next[:] = NEVER
    game.loss_tick[:] = -1
    game.contact_tick[:] = -1
    seed_game(game, np.uint64(0))


TIMERS = (
    "arrives_at",
    "stop_ends",
    "hide_ends",
    "board_ends",
    "decompress_ends",
    "cool_ends",
    "mortar_ends",
    "keep_ends",
)


def _set_up_piece(i: int, pieces: Rows, world: World) -> None:
    start, piece, rules = world.scenario.pieces[i], pieces[i], world.rules[0]
    piece.cell = start.cell
    piece.kind = start.kind
    piece.camp = start.camp
    piece.slot = i - world.side(start.camp).start
    piece.blood = rules.blood[start.kind]
    piece.ammo[:] = rules.pool_ammo[start.kind]
    piece.arrived_at = -1
    for timer in TIMERS:
        piece[timer] = NEVER
    for link in ("board_partner", "home", "carrier", "passenger"):
        piece[link] = NO_PIECE
    if start.home is not None:
        home = world.side(start.camp).start + world.piece_names(start.camp).index(start.home)
        piece.home = home
        if start.aboard:
            piece.carrier = home
            pieces[home].passenger = i
