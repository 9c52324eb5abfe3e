"""Whether arrays that come from a file are games of a world: kernels take every index in them for granted.

The ranges stand beside the records; here is what hangs together. Whatever follows from the rest, what the camps
see and remember above all, is worked out anew and compared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine import records
from hexwar_sb3.engine.fields import (
    Bounds,
    check_all,
    check_names,
    check_range,
    check_rows,
    check_same,
    copied,
)
from hexwar_sb3.engine.records import (
    BOARD_NONE,
    BOARD_ON,
    NEVER,
    NO_CELL,
    NO_PIECE,
    ROUND_BURSTING,
    ROUND_FLYING,
    ROUND_FREE,
)
from hexwar_sb3.engine.sight import look_all, remember
from hexwar_sb3.engine.state import TIMERS, State, seed_game
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Rows
from hexwar_sb3.records import fields_of
from hexwar_sb3.rules.enums import Camp, HopClass, PieceType

TABLES = {
    "games": fields_of(records.GameRecord),
    "pieces": fields_of(records.PieceRecord),
    "memory": fields_of(records.MemoryRecord),
    "rounds": fields_of(records.RoundRecord),
    "orders": fields_of(records.OrderRecord),
    "log": fields_of(records.LogRecord),
}
_FIXED = (
    "end_tick",
    "net_score",
    "fog",
    "n_red",
    "n_pieces",
    "n_points",
    "early_end",
    "point_cell",
    "point_value",
)
_CLEARED = ("path_len", "hidden", "suppressed", "waiting", "stop_forced", "stop_pending", "board_kind")
_SEEN_AS = (
    "cell",
    "tick",
    "still_since",
    "first_tick",
    "next_cell",
    "blood",
    "hidden",
    "suppressed",
    "moving",
    "seen",
)


def check_state(world: World, arrays: Mapping[str, NDArray[Any]], like: State, start: State) -> State:
    """Check the arrays of running games.

    Args:
        world: in which they play.
        arrays: by the names of `State`.
        like: as many games as there must be.
        start: the first tick of one.

    Returns:
        Copies, as kernels take them.

    Raises:
        CheckpointError: they are no games of this world.
    """
    names = [field.name for field in fields(State)]
    check_names(arrays, names)
    state = State(*(copied(name, arrays[name], getattr(like, name)) for name in names))
    check_range("paths", state.paths, 0, world.cells.neighbour.shape[1] - 1)
    bounds = bounds_of(world, state)
    for name, table in TABLES.items():
        check_rows(name, getattr(state, name), table, bounds)
    _check_games(state, start)
    _check_starts(world, state, start)
    _check_timers(state.pieces)
    _check_links(state.pieces)
    _check_boarding(state.pieces)
    _check_ways(world, state)
    _check_memory(world, state)
    _check_rounds(world, state)
    _check_fights(state)
    return state


def bounds_of(world: World, state: State) -> Bounds:
    """What the words in the tables of records mean in these games."""
    rules = world.rules[0]
    numbers = {name: int(rules[name]) for name in rules.dtype.names or () if not np.ndim(rules[name])}
    return numbers | {
        "tick": state.games.tick.astype(np.int64),
        "end_tick": world.scenario.game_ticks,
        "pieces": world.n_pieces,
        "last_piece": world.n_pieces - 1,
        "slot_bits": (1 << max(len(world.piece_names(camp)) for camp in (Camp.RED, Camp.BLUE))) - 1,
        "points": len(world.scenario.points),
        "last_point": max(0, len(world.scenario.points) - 1),
        "last_cell": world.cells.size - 1,
        "most_blood": int(rules.blood.max()),
        "most_ammo": int(rules.pool_ammo.max()),
        "longest_hop": int(max(rules.base_hop.max(), world.cells.hop_ticks.max())),
        "log": state.log.shape[1],
    }


def _check_games(state: State, start: State) -> None:
    games = state.games
    check_same("games", games, start.games, _FIXED)
    seeded = games.copy()
    for game in seeded:
        seed_game(game, game.seed)
    check_same("games", games, seeded, ["salt"])
    dead = [((state.pieces.camp == camp) & (state.pieces.blood > 0)).sum(axis=1) == 0 for camp in range(2)]
    over = (games.tick >= games.end_tick) | ((games.early_end == 1) & (dead[0] | dead[1]))
    check_all("games.over", (games.over == 1) == over, games.over, "1 at the end of the game, and not before")


def _check_starts(world: World, state: State, start: State) -> None:
    """What a piece is stays as it was, what it has gets less, and it stands where it can."""
    pieces, rules, cells = state.pieces, world.rules[0], world.cells
    check_same("pieces", pieces, start.pieces, ("kind", "camp", "slot", "home"))
    check_same("rounds", state.rounds, start.rounds, ("owner",))
    check_all("pieces.blood", pieces.blood <= rules.blood[pieces.kind], pieces.blood, "what its type has")
    check_all(
        "pieces.ammo", pieces.ammo <= rules.pool_ammo[pieces.kind], pieces.ammo, "what its type carries"
    )
    stands = np.where(
        pieces.kind == PieceType.AEROCRAFT, cells.playable[pieces.cell], cells.passable[pieces.cell]
    )
    check_all("pieces.cell", stands == 1, pieces.cell, "a cell that the piece may enter")


def _check_timers(pieces: Rows) -> None:
    """Timers run for living pieces, with that of which they are the end."""
    dead = pieces.blood == 0
    for timer in TIMERS:
        check_all(
            f"pieces.{timer}", ~dead | (pieces[timer] == NEVER), pieces[timer], "no timer of a dead piece"
        )
    for name in _CLEARED:
        check_all(f"pieces.{name}", ~dead | (pieces[name] == 0), pieces[name], "0 for a dead piece")
    suppressed = pieces.suppressed == 1
    check_all(
        "pieces.keep_ends",
        suppressed == (pieces.keep_ends != NEVER),
        pieces.keep_ends,
        "an end of suppression",
    )
    fits = suppressed | (pieces.decompress_ends == NEVER)
    check_all("pieces.decompress_ends", fits, pieces.decompress_ends, "suppression to work free of")
    grounded = ~suppressed | (pieces.kind != PieceType.AEROCRAFT)
    check_all("pieces.suppressed", grounded, pieces.suppressed, "0 for an aerocraft")


def _check_links(pieces: Rows) -> None:
    """Carriers and passengers name each other."""
    own = np.arange(pieces.shape[1])
    for link, back, kind, other_kind in (
        ("carrier", "passenger", PieceType.SOLDIER, PieceType.CHARIOT),
        ("passenger", "carrier", PieceType.CHARIOT, PieceType.SOLDIER),
    ):
        linked, other = _linked(pieces, link)
        fits = (other[back] == own) & (pieces.kind == kind) & (other.kind == other_kind)
        fits &= (other.camp == pieces.camp) & (pieces.cell == other.cell) & (pieces.blood > 0)
        check_all(f"pieces.{link}", ~linked | fits, pieces[link], "a chariot and the soldier in it")


def _check_boarding(pieces: Rows) -> None:
    own = np.arange(pieces.shape[1])
    linked, other = _linked(pieces, "board_partner")
    check_all(
        "pieces.board_kind",
        linked == (pieces.board_kind != BOARD_NONE),
        pieces.board_kind,
        "a partner of the boarding",
    )
    check_all(
        "pieces.board_ends",
        linked == (pieces.board_ends != NEVER),
        pieces.board_ends,
        "an end of the boarding",
    )
    is_soldier = pieces.kind == PieceType.SOLDIER
    fits = (other.board_partner == own) & (other.board_kind == pieces.board_kind)
    fits &= (
        (other.board_ends == pieces.board_ends) & (other.camp == pieces.camp) & (other.cell == pieces.cell)
    )
    fits &= (is_soldier & (other.kind == PieceType.CHARIOT)) | (
        (pieces.kind == PieceType.CHARIOT) & (other.kind == PieceType.SOLDIER)
    )
    aboard = np.where(is_soldier, pieces.carrier, pieces.passenger)
    fits &= np.where(pieces.board_kind == BOARD_ON, aboard == NO_PIECE, aboard == pieces.board_partner)
    check_all(
        "pieces.board_partner", ~linked | fits, pieces.board_partner, "a soldier and a chariot that board"
    )


def _linked(pieces: Rows, link: str) -> tuple[NDArray[np.bool_], Rows]:
    """Whether each piece names another one, and the piece that it names (else any)."""
    linked = pieces[link] != NO_PIECE
    at = np.arange(len(pieces))[:, None], np.where(linked, pieces[link], 0)
    return linked, pieces[at]


def _check_ways(world: World, state: State) -> None:
    """Every cell of a path can be reached from the one before, and a hop under way takes its time."""
    pieces = state.pieces
    walks = pieces.path_pos < pieces.path_len
    empty = (pieces.path_pos == 0) & (pieces.path_len == 0)
    check_all("pieces.path_pos", walks | empty, pieces.path_pos, "less than path_len, or both 0")
    moving, waiting = pieces.arrives_at != NEVER, pieces.waiting == 1
    check_all(
        "pieces.waiting", walks == (moving ^ waiting), pieces.waiting, "a path, and a hop or a wait for it"
    )
    check_all("pieces.arrives_at", walks | ~moving, pieces.arrives_at, "a hop of a path")
    last = pieces.path_len == pieces.path_pos + 1
    stops = ~(pieces.stop_pending == 1) | (walks & last)
    check_all("pieces.stop_pending", stops, pieces.stop_pending, "the last hop of a path")
    cell = pieces.cell.astype(np.int64)
    for k in range(int(pieces.path_len.max(initial=0))):
        on = walks & (k >= pieces.path_pos) & (k < pieces.path_len)
        direction = state.paths[..., k].astype(np.int64)
        beside, ticks = _hops(world, pieces.kind, cell, direction)
        check_all("paths", ~on | (ticks > 0), direction, "a direction that leads somewhere")
        first = on & (k == pieces.path_pos) & moving
        fits = (pieces.hop_need == ticks) & (pieces.arrives_at - state.games.tick[:, None] <= ticks)
        check_all("pieces.hop_need", ~first | fits, pieces.hop_need, "the ticks of the hop under way")
        cell = np.where(on, beside, cell)


def _hops(
    world: World, kind: NDArray[Any], cell: NDArray[np.int64], direction: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cell in a direction, and the ticks of the hop there, 0 where there is none: what `hop_from` says."""
    cells, rules = world.cells, world.rules[0]
    beside = cells.neighbour[cell, direction].astype(np.int64)
    hop_class = np.where(kind == PieceType.SOLDIER, HopClass.SOLDIER, HopClass.VEHICLE)
    on_ground = cells.hop_ticks[cell, hop_class, direction]
    ticks = np.where(kind == PieceType.AEROCRAFT, rules.base_hop[kind], on_ground)
    return beside, np.where(beside == NO_CELL, 0, ticks).astype(np.int64)


def _check_memory(world: World, state: State) -> None:
    """A camp remembers of the enemy what it sees now, or what it can have seen; of its own pieces nothing."""
    memory, pieces, games = state.memory, state.pieces, state.games
    camps = np.arange(2)[:, None]
    known = memory.cell != NO_CELL
    check_all("memory.cell", ~known | (pieces.camp[:, None] != camps), memory.cell, "none of an own piece")
    for name in _SEEN_AS:
        nothing = NO_CELL if name in ("cell", "next_cell") else 0
        check_all(
            f"memory.{name}", known | (memory[name] == nothing), memory[name], f"{nothing} before it was seen"
        )
    on_map = world.cells.playable[memory.cell] == 1
    check_all("memory.cell", ~known | on_map, memory.cell, "a playable cell")
    in_order = (memory.first_tick <= memory.tick) & (memory.first_tick <= memory.still_since)
    in_order &= (memory.seen == 1) | (memory.still_since <= memory.tick)
    check_all(
        "memory.still_since", ~known | in_order, memory.still_since, "first seen, since then still, last seen"
    )
    lived = memory.blood >= pieces.blood[:, None]
    lived &= memory.blood <= world.rules[0].blood[pieces.kind][:, None]
    check_all("memory.blood", ~known | lived, memory.blood, "what the piece had when it was seen")
    fits = (memory.seen == 1) | (memory.next_cell == NO_CELL)
    check_all("memory.next_cell", fits, memory.next_cell, "none of a piece out of sight")
    contact = np.where(known, memory.first_tick, -1).max(axis=2, initial=-1)
    check_all("games.contact_tick", games.contact_tick == contact, games.contact_tick, "the last first_tick")
    _check_sight(world, state)


def _check_sight(world: World, state: State) -> None:
    again = State(*(getattr(state, field.name).copy() for field in fields(State)))
    rules, cells, los = world.tables
    for b in range(len(again.games)):
        game, pieces, memory, paths, *_ = again.game(b)
        look_all(pieces, rules, cells, los)
        remember(game, pieces, memory, paths, cells)
    check_same("pieces", state.pieces, again.pieces, ("sees",))
    check_same("memory", state.memory, again.memory, _SEEN_AS)


def _check_rounds(world: World, state: State) -> None:
    rounds, rules, tick = state.rounds, world.rules[0], state.games.tick[:, None]
    owner = state.pieces[np.arange(len(rounds))[:, None], rounds.owner]
    free, flying, bursts = (rounds.status == status for status in (ROUND_FREE, ROUND_FLYING, ROUND_BURSTING))
    check_all("rounds.camp", free | (rounds.camp == owner.camp), rounds.camp, "its owner's camp")
    for name, ticks in (("land_at", rules.flight_ticks), ("end_at", rules.burst_ticks)):
        fits = rounds[name] == rounds.fired_at + ticks
        check_all(f"rounds.{name}", free | fits, rounds[name], f"{ticks} ticks after fired_at")
    check_all("rounds.land_at", ~flying | (rounds.land_at > tick), rounds.land_at, "a tick to come")
    check_all("rounds.land_at", ~bursts | (rounds.land_at <= tick), rounds.land_at, "a tick that was")
    check_all("rounds.end_at", free | (rounds.end_at > tick), rounds.end_at, "a tick to come")
    playable = world.cells.playable
    check_all("rounds.cell", free | (playable[rounds.cell] == 1), rounds.cell, "a playable cell")
    hit = (rounds.impact != NO_CELL) & (playable[rounds.impact] == 1)
    check_all("rounds.impact", ~bursts | hit, rounds.impact, "a playable cell")
    check_all(
        "rounds.judged", ~flying | (rounds.judged == 0).all(axis=-1), rounds.judged, "0 before it lands"
    )


def _check_fights(state: State) -> None:
    """Each close combat has a cell of its own, with both camps in it, and a next exchange."""
    games, pieces = state.games, state.pieces
    fights = games.fight_cell != NO_CELL
    last = np.where(fights, np.arange(1, fights.shape[1] + 1), 0).max(axis=1)
    check_all("games.n_fights", games.n_fights == last, games.n_fights, "the last row with a fight")
    check_all(
        "games.fight_next", fights == (games.fight_next != NEVER), games.fight_next, "a tick for each fight"
    )
    stands = (pieces.blood > 0) & (pieces.carrier == NO_PIECE) & (pieces.kind != PieceType.AEROCRAFT)
    for camp in (Camp.RED, Camp.BLUE):
        there = (
            stands[:, None]
            & (pieces.camp == camp)[:, None]
            & (pieces.cell[:, None] == games.fight_cell[..., None])
        )
        check_all(
            "games.fight_cell", ~fights | there.any(axis=2), games.fight_cell, "a cell that holds both camps"
        )
    same = games.fight_cell[:, :, None] == games.fight_cell[:, None, :]
    check_all("games.fight_cell", ~fights | (same.sum(axis=2) == 1), games.fight_cell, "each cell once")
