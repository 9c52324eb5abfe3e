"""The state of a batch of games as a few record arrays (architecture.md, section 2).

A game is one row of each array; a snapshot is a copy of those rows (about 4 KB).
Times are END TICKS, never counters: a timer of n set in step t holds t + n and is over in the
state of that tick. `NEVER` marks a timer that does not run. Red's pieces come first.

Each class gives the least and the most that a field of a running game may hold, in numbers or in the words of
`sound.bounds_of`; what hangs together is checked in `sound.py`.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.fields import ANY_I1, ANY_U8
from hexwar_sb3.maps import cells
from hexwar_sb3.records import I1, I2, I4, U8, Table, Vector, dtype_of, within
from hexwar_sb3.rules.enums import Action, Camp, PieceType, Weapon
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, PointIndex, SlotIndex

NO_CELL = cells.NO_CELL  # off the map, void, or never seen
NEVER = 32767  # end tick of a timer that does not run
NO_PIECE = PieceIndex(-1)
NO_POINT = PointIndex(-1)

MAX_SIDE = 64  # pieces of a camp: `sees` has 64 bits
MAX_PIECES = 2 * MAX_SIDE
MAX_POINTS = 16
PATH_CELLS = 100

BOARD_NONE, BOARD_ON, BOARD_OFF = 0, 1, 2
ROUND_FREE, ROUND_FLYING, ROUND_BURSTING = 0, 1, 2


class GameRecord:
    """One game."""

    seed: U8[np.uint64] = within(0, ANY_U8)
    salt: Vector[CampIndex, U8[np.uint64]] = within(0, ANY_U8, (2,))  # [camp] dice salts, from the seed
    tick: I2[int] = within(0, "end_tick")
    end_tick: I2[int] = within(0, "end_tick")
    over: I1[int] = within(0, 1)
    net_score: I1[int] = within(0, 1)  # 1: own - enemy, 0: eq. (1) literally
    fog: I1[int] = within(0, 1)  # 0: lights on (debugging only)
    n_red: I2[int] = within(0, "pieces")
    n_pieces: I2[int] = within(0, "pieces")
    n_points: I1[int] = within(0, "points")
    early_end: I1[int] = within(0, 1)
    point_owner: Vector[PointIndex, I1[CampIndex]] = within(0, Camp.GREEN, (MAX_POINTS,))  # Camp
    point_cell: Vector[PointIndex, I4[CellIndex]] = within(0, "last_cell", (MAX_POINTS,))
    point_value: Vector[PointIndex, I2[int]] = within(0, NEVER, (MAX_POINTS,))
    n_fights: I1[int] = within(0, MAX_SIDE)  # rows of the next two that are in use, up to the last one
    # NO_CELL: free row
    fight_cell: Vector[int, I4[CellIndex]] = within(0, "last_cell", (MAX_SIDE,), also=(NO_CELL,))
    # tick whose step makes the next exchange
    fight_next: Vector[int, I2[int]] = within("tick", ("tick", "fight_ticks"), (MAX_SIDE,), also=(NEVER,))
    # [camp] last tick with an own loss; -1 before
    loss_tick: Vector[CampIndex, I2[int]] = within(-1, "tick", (2,))
    # [camp] last tick at which an enemy came into sight; -1 before
    contact_tick: Vector[CampIndex, I2[int]] = within(-1, "tick", (2,))
    log_count: I4[int] = within(0, "log")


GAME = dtype_of(GameRecord)


class PieceRecord:
    """One piece; `stop_ends` etc. are NEVER when idle. Path empty and all four transitions idle: settled."""

    sees: U8[np.uint64] = within(0, "slot_bits")  # bit s: this piece itself sees the enemy in slot s
    cell: I4[CellIndex] = within(0, "last_cell")
    # end of the hop under way; NEVER: none
    arrives_at: I2[int] = within(("tick", 1), ("tick", "longest_hop"), also=(NEVER,))
    hop_need: I2[int] = within(0, "longest_hop")  # ticks of the hop under way
    stop_ends: I2[int] = within(("tick", 1), ("tick", "stop_ticks"), also=(NEVER,))
    hide_ends: I2[int] = within(("tick", 1), ("tick", "hide_ticks"), also=(NEVER,))
    board_ends: I2[int] = within(("tick", 1), ("tick", "board_ticks"), also=(NEVER,))
    decompress_ends: I2[int] = within(("tick", 1), ("tick", "decompress_ticks"), also=(NEVER,))
    cool_ends: I2[int] = within(("tick", 1), ("tick", "cool_ticks"), also=(NEVER,))
    mortar_ends: I2[int] = within(("tick", 1), ("tick", "mortar_cool_ticks"), also=(NEVER,))
    keep_ends: I2[int] = within(("tick", 1), ("tick", "keep_ticks"), also=(NEVER,))
    arrived_at: I2[int] = within(-1, "tick")  # tick of the last arrival in a cell; -1 before
    path_pos: I1[int] = within(0, PATH_CELLS)  # next direction of paths[piece] to walk
    path_len: I1[int] = within(0, PATH_CELLS)  # path is empty when path_pos == path_len
    kind: I1[int] = within(0, len(PieceType) - 1)  # PieceType
    camp: I1[CampIndex] = within(0, 1)
    slot: I1[SlotIndex] = within(0, MAX_SIDE - 1)  # index within its camp
    blood: I1[int] = within(0, "most_blood")  # 0: destroyed
    hidden: I1[int] = within(0, 1)
    suppressed: I1[int] = within(0, 1)
    waiting: I1[int] = within(0, 1)  # has a path but cannot start its hop
    stop_forced: I1[int] = within(0, 1)  # the transition under way (or after this hop) was ordered
    stop_pending: I1[int] = within(0, 1)  # a stop order waits for the end of this hop
    board_kind: I1[int] = within(BOARD_NONE, BOARD_OFF)  # BOARD_*
    board_partner: I1[PieceIndex] = within(NO_PIECE, "last_piece")
    home: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # a soldier's chariot
    carrier: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # NO_PIECE: not aboard
    passenger: I1[PieceIndex] = within(NO_PIECE, "last_piece")
    ammo: Vector[int, I1[int]] = within(0, "most_ammo", (4,))  # [pool]
    losses_now: I1[int] = within(0, 0)  # scratch of the step under way, zero between steps:
    hit_now: I1[int] = within(0, 0)  # some result >= 0
    zero_now: I1[int] = within(0, 0)  # some result = 0
    spent_now: Vector[int, I1[int]] = within(0, 0, (4,))  # [pool] rounds fired in close combat
    covered_now: I1[int] = within(0, 0)  # hidden or aboard when the step began
    came_now: I1[int] = within(0, 0)  # it came into its cell
    changed_now: I1[int] = within(0, 0)  # whom it sees, and who sees it, is to be renewed


PIECE = dtype_of(PieceRecord)


class MemoryRecord:
    """What a camp knows of an enemy piece (u(sigma, t), III-A)."""

    cell: I4[CellIndex] = within(NO_CELL, "last_cell")  # NO_CELL: never seen
    tick: I2[int] = within(0, "tick")  # last tick at which it was seen (exact once `seen` is 0)
    still_since: I2[int] = within(0, "tick")  # tick since which it has been seen in this cell
    first_tick: I2[int] = within(0, "tick")  # tick of the last change from unseen to seen
    next_cell: I4[CellIndex] = within(NO_CELL, "last_cell")  # where its hop under way leads; NO_CELL
    blood: I1[int] = within(0, "most_blood")
    hidden: I1[int] = within(0, 1)
    suppressed: I1[int] = within(0, 1)
    moving: I1[int] = within(0, 1)  # in_motion as last seen
    seen: I1[int] = within(0, 1)  # seen now


MEMORY = dtype_of(MemoryRecord)
"""memory[camp, piece]."""


class RoundRecord:
    """One mortar round."""

    owner: I1[PieceIndex] = within(0, "last_piece")
    camp: I1[CampIndex] = within(0, 1)
    status: I1[int] = within(ROUND_FREE, ROUND_BURSTING)  # ROUND_*
    blood_at_launch: I1[int] = within(0, "most_blood")
    hit: I1[int] = within(0, 1)  # 1 hit, 0 off target; valid while bursting
    cell: I4[CellIndex] = within(0, "last_cell")  # aimed at
    impact: I4[CellIndex] = within(NO_CELL, "last_cell")
    launch_cells: I2[int] = within(0, "mortar_max_cells")
    fired_at: I2[int] = within(0, "tick")
    land_at: I2[int] = within(0, ("tick", "flight_ticks"))
    end_at: I2[int] = within(0, ("tick", "burst_ticks"))
    # [camp] bit s: its piece in slot s was judged in this burst
    judged: Vector[CampIndex, U8[np.uint64]] = within(0, "slot_bits", (2,))


ROUND = dtype_of(RoundRecord)


class OrderRecord:
    """One order for the step to come."""

    kind: I1[int] = within(0, len(Action) - 1)  # Action
    code: I1[int] = within(0, max(Code))  # Code, written by the step
    weapon: I1[int] = within(-1, len(Weapon) - 1)
    # shot at; carrier to board; passenger to set down
    target: I1[PieceIndex] = within(NO_PIECE, "last_piece")
    partner: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # guide-shoot: the chariot that launches
    path_len: I1[int] = within(0, PATH_CELLS)
    cell: I4[CellIndex] = within(NO_CELL, "last_cell")  # indirect-shoot
    path: Vector[int, I1[int]] = within(0, 5, (PATH_CELLS,))  # directions 0..5


ORDER = dtype_of(OrderRecord)


class LogRecord:
    """One event."""

    tick: I2[int] = within(0, "tick")  # of the state that the event made
    event: I1[int] = within(0, max(Event))
    a: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # actor
    b: I1[PieceIndex] = within(NO_PIECE, "last_piece")  # target or partner
    weapon: I1[int] = within(-1, len(Weapon) - 1)
    level: I1[int] = within(*ANY_I1)
    roll: I1[int] = within(*ANY_I1)
    raw: I1[int] = within(*ANY_I1)
    roll2: I1[int] = within(*ANY_I1)
    mods: I1[int] = within(*ANY_I1)
    corr: I1[int] = within(*ANY_I1)
    result: I1[int] = within(*ANY_I1)
    cell: I4[CellIndex] = within(NO_CELL, "last_cell")
    cells_apart: I2[int] = within(0, NEVER)
    extra: I2[int] = within(-NEVER, NEVER)


LOG = dtype_of(LogRecord)

Pieces: TypeAlias = Vector[PieceIndex, PieceRecord]  # of one game
Memory: TypeAlias = Table[CampIndex, PieceIndex, MemoryRecord]  # of one game
Paths: TypeAlias = Table[PieceIndex, int, int]  # directions of one game's pieces
Rounds: TypeAlias = Vector[int, RoundRecord]  # of one game
Orders: TypeAlias = Vector[PieceIndex, OrderRecord]  # of one game
Log: TypeAlias = Vector[int, LogRecord]  # of one game
